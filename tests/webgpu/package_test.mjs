// The npm package: packed, installed into an empty folder, and its example run in Dawn:
// node package_test.mjs LAYOUT
import assert from "node:assert";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { testDevice } from "./device.mjs";
import { readTexture } from "./readback.mjs";

const layout = process.argv[2];
const folder = mkdtempSync(join(tmpdir(), "pelage-package-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
const run = (program, ...values) => execFileSync(program, values, { cwd: folder, encoding: "utf8" });

const [{ filename, size }] = JSON.parse(run("npm", "pack", layout, "--json"));
console.log(`${filename}: ${(size / 1e6).toFixed(2)} MB`);
assert(size < 3e6);
writeFileSync(join(folder, "package.json"), '{"type": "module"}');
run("npm", "install", "--prefer-offline", "--no-audit", "--no-fund", filename);

// The example is correct by the types of the package.
copyFileSync(join(layout, "examples", "hair.mjs"), join(folder, "hair.mjs"));
const tsc = join(import.meta.dirname, "node_modules", "typescript", "bin", "tsc");
const options = ["--noEmit", "--checkJs", "--allowJs", "--strict", "--target", "es2022", "--lib", "es2022,dom"];
run(process.execPath, tsc, ...options, "--module", "esnext", "--moduleResolution", "bundler", "hair.mjs");

// A page without a browser: a canvas that keeps its picture.
const device = await testDevice();
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
const [width, height] = [128, 96];
const shown = device.createTexture({
  size: [width, height],
  format: "rgba8unorm",
  usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC,
});
const gpu = { requestAdapter: async () => ({ requestDevice: async () => device }), getPreferredCanvasFormat: () => "rgba8unorm" };
Object.defineProperty(globalThis, "navigator", { value: { gpu }, configurable: true });
const canvas = {
  clientWidth: width,
  clientHeight: height,
  getContext: () => ({ configure() {}, getCurrentTexture: () => shown }),
};
const waiting = [];
globalThis.requestAnimationFrame = (frame) => waiting.push(frame);

const { addHair } = await import(pathToFileURL(join(folder, "hair.mjs")).href);
const { scene, stop } = await addHair(canvas, { groom: "mohawk", wind: [1, 0, 0] });
assert.deepEqual(scene.parameters.find(({ path }) => path === "wind.velocity").value, [1, 0, 0]);
for (let i = 0; i < 2; ++i) await waiting.shift()(performance.now());
const pixels = await readTexture(device, shown, 4);
assert.deepEqual(errors, []);
// The mohawk is red.
let red = 0;
for (let i = 0; i < pixels.length; i += 4) if (pixels[i] > 2 * pixels[i + 1] && pixels[i] > 60) ++red;
console.log(`${red} of ${width * height} pixels show red hair`);
assert(red > 0.01 * width * height);
stop();
await waiting.shift()(performance.now());
assert.equal(waiting.length, 0, "it has stopped");
process.exit(0);
