// The core as WebAssembly writes frames whose picture is that of the core on Vulkan:
// node wasm_test.mjs SITE FOLDER. record_scene.cpp has the same scene.
import assert from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { testDevice } from "./device.mjs";
import { checkPicture, checkPositions, readBuffer, readPicture } from "./readback.mjs";
import { Core } from "./web_scene.mjs";

const [site, folder] = process.argv.slice(2);
const device = await testDevice();
const { View } = await import("./view.mjs");
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
const variants = JSON.parse(readFileSync(join(site, "kernels.json"), "utf8"));
const core = await Core.load(readFileSync(join(site, "pelage.wasm")));
const recorded = JSON.parse(readFileSync(join(folder, "page", "scene.json"), "utf8"));
const bytes = readFileSync(join(folder, "page", "scene.bin"));
const { width, height } = recorded.picture;

const scene = core.head({ strands: 500, follow: 0, seed: 7 });
const camera = { eye: [0.2, 0.2, 0.8], target: [0, 0.15, 0], verticalFov: 0.6, width, height };

// Values that are wrong are refused, with a message that names them.
assert.throws(() => scene.set("simulation", "nothing", [1]), /no parameter simulation\.nothing/);
assert.throws(() => scene.set("material", "opacity", [7]), /material\.opacity.*7/);
assert.throws(() => scene.set("material", "opacity", [0.5, 0.5]), /2/);
assert.throws(() => scene.frame(1 / 60, { ...camera, width: 0 }), /1 to 16384 pixels/);
assert.throws(() => core.hair(new Uint8Array(10)), /hair\.tfx/);
assert.throws(() => core.head({ strands: 0 }), /strandCount/);
assert.throws(() => core.head({ groom: "bald" }), /no groom 'bald'.*curly/);

scene.set("material", "fiberRadius", [0.001]);
scene.set("simulation", "wind.velocity", [2, 0, 0]);
const radius = scene.parameters.find(({ section, path }) => section === "material" && path === "fiberRadius");
assert.equal(radius.value, Math.fround(0.001));
assert(radius.meaning !== "" && radius.slider[0] < radius.slider[1]);

const view = new View(device, variants, scene);
view.resize(width, height);
for (const _ of recorded.frames) {
  view.draw(1 / 60, camera);
  await device.queue.onSubmittedWorkDone();
}
assert.deepEqual(errors, []);

const floatsAt = (offset, size) => new Float32Array(new Uint8Array(bytes.subarray(offset, offset + size)).buffer);
const [positions] = recorded.outputs;
checkPositions(
  new Float32Array((await readBuffer(device, view.executor.buffer(scene.positionsBuffer(0)))).buffer),
  floatsAt(positions.expected, positions.size),
);
checkPicture(await readPicture(device, view.color), floatsAt(recorded.picture.expected, 16 * width * height));
assert.throws(() => scene.positionsBuffer(1), /hair object 1/);
scene.destroy();
process.exit(0);
