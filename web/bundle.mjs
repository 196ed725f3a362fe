// Writes what a page needs as static files: node bundle.mjs REFLECTION WASM FOLDER
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { readKernels } from "./kernels.mjs";

const [reflection, wasm, folder] = process.argv.slice(2);
if (!folder) {
  console.error("usage: node bundle.mjs REFLECTION WASM FOLDER");
  process.exit(2);
}
const own = import.meta.dirname;
const files = ["executor.mjs", "web_scene.mjs"];

// Draws of tiles alone: the other vertex and pixel kernels are left out.
const drawn = new Set(["oit_tile_vertex", "show_strand_tiles"]);
const variants = readKernels(reflection).variants.filter(({ stage, kernel }) => stage === "compute" || drawn.has(kernel));

mkdirSync(folder, { recursive: true });
for (const file of files) copyFileSync(join(own, file), join(folder, file));
copyFileSync(wasm, join(folder, "pelage.wasm"));
writeFileSync(join(folder, "kernels.json"), JSON.stringify(variants));

let sum = 0;
for (const file of [...files, "pelage.wasm", "kernels.json"])
  sum += gzipSync(readFileSync(join(folder, file)), { level: 9 }).length;
console.log(`${folder}: ${(sum / 1e6).toFixed(2)} MB over the wire, compressed by gzip`);
