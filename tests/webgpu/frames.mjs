// Measures frames of the page's scenes in Node.js, by Dawn on the adapter that there is, and writes
// the last one as a picture:
//   node frames.mjs SITE OUT [frames] [width] [height] [scene ...]
// Needs device.mjs, png.mjs, readback.mjs and node_modules/webgpu beside it, and the folder SITE.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { testDevice } from "./device.mjs";
import { writePng } from "./png.mjs";
import { readTexture } from "./readback.mjs";

const [site, out, frames = "100", width = "1920", height = "1080", ...names] = process.argv.slice(2);
if (!out) {
  console.error("usage: node frames.mjs SITE OUT [frames] [width] [height] [scene ...]");
  process.exit(2);
}
const WARM_UP = 5; // frames that compile pipelines, not measured
const device = await testDevice();
device.addEventListener("uncapturederror", ({ error }) => {
  console.error(error.message);
  process.exit(1);
});
/** @param {string} file of the page */
const load = (file) => import(pathToFileURL(resolve(site, file)).href);
const { Core } = await load("web_scene.mjs");
const { View } = await load("view.mjs");
const { SCENES } = await load("scenes.mjs");
let loadBegin = performance.now(); // of the scene and, at first, the core
const variants = JSON.parse(readFileSync(join(site, "kernels.json"), "utf8"));
const core = await Core.load(readFileSync(join(site, "pelage.wasm")));

const size = [Number(width), Number(height)];
const shown = device.createTexture({
  size,
  format: "rgba8unorm",
  usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC,
});

/** @param {number[]} values */
function median(values) {
  return [...values].sort((a, b) => a - b)[values.length >> 1];
}

for (const name of names.length > 0 ? names : Object.keys(SCENES)) {
  const scene = SCENES[name](core);
  const view = new View(device, variants, scene);
  view.resize(...size);
  const camera = scene.camera(size[0] / size[1]);
  const draw = () => {
    const begin = performance.now();
    view.draw(1 / 60, camera);
    view.show(shown.createView(), "rgba8unorm");
    return performance.now() - begin;
  };
  /** Milliseconds of frames, and of the host in them. @param {number} open that the device has not finished */
  const measure = async (open) => {
    const [each, host, waiting] = [[], [], []];
    for (let i = 0; i < Number(frames); ++i) {
      const begin = performance.now();
      host.push(draw());
      waiting.push(device.queue.onSubmittedWorkDone());
      if (waiting.length >= open) await waiting.shift();
      each.push(performance.now() - begin);
    }
    await Promise.all(waiting);
    return { each: median(each), host: median(host) };
  };
  await view.prepare(1 / 60, camera);
  await device.queue.onSubmittedWorkDone();
  const first = performance.now() - loadBegin;
  for (let i = 0; i < WARM_UP; ++i) {
    draw();
    await device.queue.onSubmittedWorkDone();
  }
  const alone = await measure(1);
  const two = await measure(2);
  const text = (/** @type {number} */ value) => value.toFixed(2);
  console.log(
    `${name}, ${width} x ${height}, median of ${frames} frames: ${text(alone.each)} ms a frame, ` +
      `${text(alone.host)} ms of it on the host; ${text(two.each)} ms with two frames in flight; ` +
      `the first picture after ${text(first / 1000)} s`,
  );
  writePng(join(out, `${name}.png`), ...size, await readTexture(device, shown, 4));
  view.destroy();
  scene.destroy();
  loadBegin = performance.now();
}
process.exit(0);
