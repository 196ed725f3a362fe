// What the page draws, in Dawn: the body, its depth for the hair, and the picture on a canvas:
// node view_test.mjs SITE
import assert from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { testDevice } from "./device.mjs";
import { readPicture } from "./readback.mjs";
import { Core } from "./web_scene.mjs";

const site = process.argv[2];
const device = await testDevice();
const { View } = await import("./view.mjs");
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
const variants = JSON.parse(readFileSync(join(site, "kernels.json"), "utf8"));
const core = await Core.load(readFileSync(join(site, "pelage.wasm")));

/** Pixels of a picture that a test is true for. */
function count(pixels, test) {
  let found = 0;
  for (let i = 0; i < pixels.length; i += 4) if (test(pixels[i], pixels[i + 1], pixels[i + 2])) ++found;
  return found;
}
const isSkin = (red, green, blue) => red > 0.06 && red > 1.5 * green && red > 1.8 * blue;
const isBackground = (red, green, blue) => Math.abs(red - 0.02) < 1e-3 && Math.abs(green - 0.022) < 1e-3 && Math.abs(blue - 0.027) < 1e-3;

const scene = core.head(300, 7);
// Light that hair has never: fibers that are seen are green.
scene.set("material", "rootColor", [0, 1, 0]);
scene.set("material", "tipColor", [0, 1, 0]);
scene.set("material", "fiberRadius", [0.001]);
const isHair = (red, green, blue) => green > 0.05 && green > 1.5 * red;
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
  return { skin, hair, background };
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
  const value = Math.min(Math.max(linear[i], 0), 1);
  const wanted = value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
  assert(Math.abs(encoded[i] - wanted) < 2e-3, `pixel ${i >> 2}: ${encoded[i]}, not ${wanted}`);
}
view.destroy();
scene.destroy();
process.exit(0);
