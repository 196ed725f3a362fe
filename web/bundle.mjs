// Writes the page as static files: node bundle.mjs WASM FOLDER REFLECTION...
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { readKernels } from "./kernels.mjs";

const [wasm, folder, ...reflections] = process.argv.slice(2);
if (reflections.length === 0) {
  console.error("usage: node bundle.mjs WASM FOLDER REFLECTION...");
  process.exit(2);
}
const own = import.meta.dirname;
const files = [
  "page.html",
  "page.css",
  "page.mjs",
  "controls.mjs",
  "mouse.mjs",
  "scenes.mjs",
  "view.mjs",
  "executor.mjs",
  "web_scene.mjs",
];
const pictures = ["contact_sheet.png", "gallery_curly.png"]; // loaded where there is no WebGPU
const MOST_BYTES = 3e6; // compressed

// Draws of tiles and of the body alone: the other vertex and pixel kernels are not for the page.
const drawn = new Set(["oit_tile_vertex", "show_strand_tiles", "mesh_vertex", "mesh_pixel"]);
const variants = reflections
  .flatMap((path) => readKernels(path).variants)
  .filter(({ stage, kernel }) => stage === "compute" || drawn.has(kernel));

mkdirSync(folder, { recursive: true });
for (const file of [...files, ...pictures]) {
  const from = join(own, file);
  copyFileSync(from, join(folder, file === "page.html" ? "index.html" : file));
}
copyFileSync(wasm, join(folder, "pelage.wasm"));
writeFileSync(join(folder, "kernels.json"), JSON.stringify(variants));

let sum = 0;
for (const file of [...files.slice(1), "index.html", "pelage.wasm", "kernels.json"])
  sum += gzipSync(readFileSync(join(folder, file)), { level: 9 }).length;
console.log(`${folder}: ${(sum / 1e6).toFixed(2)} MB over the wire, compressed by gzip`);
if (sum > MOST_BYTES) throw new Error(`the page has more than ${MOST_BYTES} bytes`);
