// Hair and fur on WebGPU: docs/webgpu.md of pelage.
/// <reference types="@webgpu/types" preserve="true" />
import { Core } from "./web_scene.mjs";

export { Executor, readFrame } from "./executor.mjs";
export { Core, DEPTH_LIST, GROOMS, Scene } from "./web_scene.mjs";
export { View } from "./view.mjs";

/** @param {URL} url @returns {Promise<Response>} */
async function get(url) {
  // Node.js does not fetch files, and its modules are nothing that bundlers find.
  const files = "node:fs/promises";
  if (url.protocol === "file:") return new Response(await (await import(files)).readFile(url));
  const response = await fetch(url);
  if (!response.ok) throw new Error(`cannot load ${url}: ${response.status}`);
  return response;
}

/**
 * Loads the core and the kernels, which lie beside this module.
 * @returns {Promise<{core: Core, variants: import("./executor.mjs").Variant[]}>}
 */
export async function load() {
  const [wasm, kernels] = await Promise.all([
    get(new URL("pelage.wasm", import.meta.url)),
    get(new URL("kernels.json", import.meta.url)),
  ]);
  return { core: await Core.load(await wasm.arrayBuffer()), variants: await kernels.json() };
}
