// What the page draws, in Dawn: the body, its depth for the hair, and the picture on a canvas:
// node view_test.mjs SITE
import assert from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { testDevice } from "./device.mjs";
import { readBuffer, readPicture } from "./readback.mjs";
import { Core } from "./web_scene.mjs";

const site = process.argv[2];
const BACKGROUND = [0.05, 0.055, 0.065]; // of what is shown
const device = await testDevice();
const { View } = await import("./view.mjs");
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
const variants = JSON.parse(readFileSync(join(site, "kernels.json"), "utf8"));
const core = await Core.load(readFileSync(join(site, "pelage.wasm")));

/** Pixels of a picture that a test is true for. */
function count(pixels, test) {
  let found = 0;
  for (let i = 0; i < pixels.length; i += 4) if (test(...pixels.subarray(i, i + 4))) ++found;
  return found;
}
const isSkin = (red, green, blue, alpha) => alpha > 0.9 && red > 0.06 && red > 1.15 * green;
const isHair = (red, green) => green > 0.05 && green > 1.5 * red;
const isBackground = (red, green, blue, alpha) => alpha < 0.01;

const scene = core.head({ strands: 300, follow: 0, seed: 7 });
// Light that hair has never: fibers that are seen are green.
scene.set("material", "model", [0]);
scene.set("material", "rootColor", [0, 1, 0]);
scene.set("material", "tipColor", [0, 1, 0]);
scene.set("material", "fiberRadius", [0.001]);
const view = new View(device, variants, scene);
const head = { target: [0, 0.14, 0], verticalFov: 0.6 };
assert.throws(() => view.draw(0, { ...head, eye: [0, 0.14, 0.8] }), /resize/);
assert.throws(() => view.resize(100, 100), /multiple of 64/);

async function drawn(eye, width, height) {
  view.resize(width, height);
  view.draw(1 / 60, { ...head, eye });
  const pixels = await readPicture(device, view.color);
  assert.deepEqual(errors, []);
  assert.equal(pixels.length, 4 * width * height);
  const [skin, hair, background] = [isSkin, isHair, isBackground].map((test) => count(pixels, test) / (width * height));
  console.log(`${width} x ${height}: ${[skin, hair, background].map((share) => (100 * share).toFixed(1)).join(" %, ")} % of skin, hair and background`);
  return { skin, hair, background, pixels };
}
// From the front and from the back, where there is no face; another size has the same picture.
const front = await drawn([0, 0.14, 0.8], 320, 240);
const larger = await drawn([0, 0.14, 0.8], 384, 288);
const back = await drawn([0, 0.14, -0.8], 320, 240);
for (const { skin, hair, background } of [front, larger, back]) assert(skin > 0.01 && hair > 0.03 && background > 0.4);
assert(Math.abs(front.skin - larger.skin) < 0.02 && Math.abs(front.hair - larger.hair) < 0.02);
assert(front.skin > 1.2 * back.skin, "the head hides the hair behind it");

// What is shown has the encoding of sRGB.
const shown = device.createTexture({
  size: [320, 240],
  format: "rgba16float",
  usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC,
});
view.show(shown.createView(), "rgba16float");
const linear = await readPicture(device, view.color);
const encoded = await readPicture(device, shown);
assert.deepEqual(errors, []);
for (let i = 0; i < linear.length; ++i) {
  if (i % 4 === 3) continue;
  const value = Math.min(Math.max(linear[i] + (1 - linear[i | 3]) * BACKGROUND[i % 4], 0), 1);
  const wanted = value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
  assert(Math.abs(encoded[i] - wanted) < 2e-3, `pixel ${i >> 2}: ${encoded[i]}, not ${wanted}`);
}
// The camera of the scene sees all of it.
const { eye, target, verticalFov } = scene.camera(4 / 3);
assert(eye[2] > 0.5 && Math.hypot(...eye.map((value, i) => value - target[i])) < 3 && verticalFov > 0.1);

// Hair follows the mouse that pulls it, and nothing is held where there is none.
const guides = async () => {
  const bytes = await readBuffer(device, view.executor.buffer(scene.positionsBuffer(0)), scene.guideBytes(0));
  return new Float32Array(bytes.buffer);
};
assert.throws(() => scene.pull(0, 0, new Uint8Array(16)), /guides have .* bytes/);
assert.equal(await view.pull(0, 0), false);
// The lowest pixel of hair: tips.
let at = back.pixels.length - 4;
while (!isHair(...back.pixels.subarray(at, at + 2))) at -= 4;
const [x, y] = [(at / 4) % 320, Math.floor(at / 4 / 320)];
assert.equal(await view.pull(x, y), true);
const before = await guides();
scene.dragTo(x + 60, y);
for (let i = 0; i < 8; ++i) view.draw(1 / 60, { ...head, eye: [0, 0.14, -0.8] });
const after = await guides();
// Seen from the back, the right of the picture is at -x.
const pulled = Math.max(...before.map((value, i) => (i % 4 === 0 ? value - after[i] : 0)));
console.log(`pulled by ${(1000 * pulled).toFixed(0)} mm`);
assert(pulled > 0.02 && pulled < 0.2);
// It goes back before the head turns, which it does from 0.2 s on.
scene.release();
for (let i = 0; i < 8; ++i) view.draw(1 / 60, { ...head, eye: [0, 0.14, -0.8] });
const released = await guides();
const left = Math.max(...before.map((value, i) => (i % 4 === 0 ? value - released[i] : 0)));
console.log(`  and at ${(1000 * left).toFixed(0)} mm after it was released`);
assert(left < 0.9 * pulled, "hair that is released goes back");

// Tiles without room are empty, until the scene knows how many fragments there are.
scene.set("material", "fiberRadius", [0.02]);
const short = await drawn([0, 0.14, -0.8], 320, 240);
for (let i = 0; i < 3; ++i) await drawn([0, 0.14, -0.8], 320, 240);
const enough = await drawn([0, 0.14, -0.8], 320, 240);
assert(enough.hair > short.hair + 0.05, "wide hair gets room");
scene.set("material", "fiberRadius", [0.001]);

// A preset sets simulation, material and follow hairs.
assert.throws(() => scene.takePreset("bald"), /no preset 'bald'.*curly/);
scene.takePreset("fur");
const value = (path) => scene.parameters.find((one) => one.path === path).value;
assert.deepEqual([value("globalStiffness"), value("fiberRadius")], [Math.fround(0.3), Math.fround(70e-6)]);
const vertices = after.length / 4;
view.draw(1 / 60, { ...head, eye: [0, 0.14, -0.8] });
assert.equal(view.executor.buffer(scene.positionsBuffer(0)).size, 16 * vertices);
assert.deepEqual(errors, []);
view.destroy();
scene.destroy();
process.exit(0);
