// The package's example for three.js in Dawn: node three_test.mjs LAYOUT
import assert from "node:assert";
import { copyFileSync, mkdirSync, rmSync, symlinkSync } from "node:fs";
import { join, resolve } from "node:path";
import { testDevice } from "./device.mjs";
import { readPicture, readTexture } from "./readback.mjs";

const layout = resolve(process.argv[2]);
const device = await testDevice();
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
const [width, height] = [192, 128];
const shown = device.createTexture({
  size: [width, height],
  format: "rgba8unorm",
  usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC,
});
const gpu = { getPreferredCanvasFormat: () => "rgba8unorm" };
Object.defineProperty(globalThis, "navigator", { value: { gpu }, configurable: true });
Object.assign(globalThis, { self: globalThis, requestAnimationFrame: () => 0, cancelAnimationFrame: () => {} });
const canvas = {
  width,
  height,
  style: {},
  addEventListener() {},
  getContext: () => ({ configure() {}, getCurrentTexture: () => shown }),
};
// The example finds the package and three.js beside this test.
const link = join(import.meta.dirname, "node_modules", "@pelage");
rmSync(link, { recursive: true, force: true });
mkdirSync(link);
symlinkSync(layout, join(link, "webgpu"));
copyFileSync(join(layout, "examples", "three.mjs"), join(import.meta.dirname, "three.mjs"));
const THREE = await import("three/webgpu");
const { addHair } = await import("./three.mjs");
const renderer = new THREE.WebGPURenderer({ device, canvas, antialias: false });
await renderer.init();
renderer.setSize(width, height, false);

// A green wall in front of the right half of the picture, and a blue one behind all of it.
const world = new THREE.Scene();
const wall = (color, x, z, size) => {
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(size, size), new THREE.MeshBasicMaterial({ color }));
  mesh.position.set(x, 0.2, z);
  world.add(mesh);
};
const { hair, camera, picture, draw } = await addHair(renderer, world, width, height, { groom: "mohawk", strands: 300 });
camera.position.set(0, 0.2, 1.2);
camera.lookAt(0, 0.2, 0);
wall(0x00ff00, 1, 0.5, 2);
wall(0x0000ff, 0, -1, 8);
hair.set("material", "fiberRadius", [0.0005]);
draw(1 / 60);
await device.queue.onSubmittedWorkDone();
assert.deepEqual(errors, []);
const pixels = await readPicture(device, renderer.backend.get(picture.texture).texture);
const share = (from, to, test) => {
  let found = 0;
  for (let y = 0; y < height; ++y)
    for (let x = from; x < to; ++x) if (test(...pixels.subarray(4 * (y * width + x), 4 * (y * width + x) + 3))) ++found;
  return found / (height * (to - from));
};
const isGreen = (r, g, b) => g > 0.9 && r < 0.1 && b < 0.1;
const isBlue = (r, g, b) => b > 0.9 && r < 0.1 && g < 0.1;
const isHair = (r, g, b) => r > 0.05 && r > 2 * g && r > 2 * b;
const half = width / 2;
const [green, blue, hairs] = [share(half + 2, width, isGreen), share(0, half - 2, isBlue), share(0, half - 2, isHair)];
console.log(`right: ${(100 * green).toFixed(1)} % green; left: ${(100 * blue).toFixed(1)} % blue, ${(100 * hairs).toFixed(1)} % hair`);
assert(green === 1, "the wall hides hair and head");
assert(blue > 0.4 && blue < 0.95 && hairs > 0.005, "hair and head hide the other wall");
const bytes = await readTexture(device, shown, 4);
const inWall = 4 * ((height / 2) * width + (3 * width) / 4);
assert.deepEqual([...bytes.subarray(inWall, inWall + 3)], [0, 255, 0], "the picture is shown");
process.exit(0);
