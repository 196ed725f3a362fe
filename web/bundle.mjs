// Writes the page as static files: node bundle.mjs REFLECTION WASM FOLDER
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
const files = ["page.html", "page.css", "page.mjs", "scenes.mjs", "view.mjs", "executor.mjs", "web_scene.mjs"];

// Draws of tiles alone: the other vertex and pixel kernels are not for the page.
const drawn = new Set(["oit_tile_vertex", "show_strand_tiles"]);
const variants = readKernels(reflection).variants.filter(({ stage, kernel }) => stage === "compute" || drawn.has(kernel));

mkdirSync(folder, { recursive: true });
for (const file of files) {
  const from = join(own, file);
  copyFileSync(from, join(folder, file === "page.html" ? "index.html" : file));
}
copyFileSync(wasm, join(folder, "pelage.wasm"));
writeFileSync(join(folder, "kernels.json"), JSON.stringify(variants));

let sum = 0;
for (const file of [...files.slice(1), "index.html", "pelage.wasm", "kernels.json"])
  sum += gzipSync(readFileSync(join(folder, file)), { level: 9 }).length;
console.log(`${folder}: ${(sum / 1e6).toFixed(2)} MB over the wire, compressed by gzip`);
