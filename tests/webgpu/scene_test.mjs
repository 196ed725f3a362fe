// Hair on WebGPU is where it is on Vulkan, and looks like it: node scene_test.mjs REFLECTION FOLDER
import assert from "node:assert";
import { join } from "node:path";
import { testDevice } from "./device.mjs";
import { readKernels } from "./kernels.mjs";

const { variants } = readKernels(process.argv[2]);
const device = await testDevice();
const { replay } = await import("./replay.mjs");
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));

/** @returns {number[]} in meters, ascending */
function distancesOf(a, b) {
  const distances = [];
  for (let i = 0; i < a.length; i += 4)
    distances.push(Math.hypot(...[0, 1, 2].map((axis) => a[i + axis] - b[i + axis])));
  assert(distances.every(Number.isFinite));
  return distances.sort((x, y) => x - y);
}

function checkPositions(positions, expected) {
  const distances = distancesOf(positions, expected);
  const sum = positions.reduce((total, value, i) => total + (i % 4 === 0 ? value : 0), 0);
  assert((4 * sum) / positions.length > 0.5, "the hair is where its bone has gone, by 1 m along x");
  const median = 1000 * distances[distances.length >> 1];
  const most = 1000 * distances[distances.length - 1];
  const equal = distances.filter((d) => d === 0).length;
  console.log(`  ${distances.length} vertices, ${equal} with the same bits, median ${median} mm, maximum ${most} mm`);
  assert(median <= 0.1, "the median vertex is within 0.1 mm");
}

// Distances that are quantized, with a triangle of equal distance where there are several.
function checkKeys(keys, expected) {
  const equal = keys.reduce((count, key, i) => count + (key === expected[i] ? 1 : 0), 0);
  console.log(`  ${keys.length} keys of the SDF, ${equal} with the same bits`);
  assert(equal >= 0.99 * keys.length);
}

function checkPicture(pixels, expected) {
  assert.equal(pixels.length, expected.length);
  const clamped = (value) => Math.min(Math.max(value, 0), 1);
  const errors = pixels.map((value, i) => (clamped(value) - clamped(expected[i])) ** 2);
  assert(errors.every(Number.isFinite));
  const mean = errors.reduce((sum, value) => sum + value, 0) / errors.length;
  const ratio = -10 * Math.log10(mean);
  const covered = expected.reduce((count, value, i) => count + (i % 4 === 3 && value > 0.5 ? 1 : 0), 0);
  console.log(`  a picture with ${covered} of ${expected.length / 4} pixels of hair, ${ratio.toFixed(1)} dB`);
  assert(covered > 0.05 * (expected.length / 4), "the picture shows hair");
  assert(ratio >= 50, "the picture is Vulkan's");
}

const floats = (bytes) => new Float32Array(bytes.buffer);
const words = (bytes) => new Uint32Array(bytes.buffer);

const ran = new Set();
for (const name of ["exact", "contacts", "classic", "head", "drawn"]) {
  const { outputs, picture, kernels } = await replay(device, variants, join(process.argv[3], name));
  assert.deepEqual(errors, []);
  console.log(`${name}: ${[...kernels].filter(Boolean).join(", ")}`);
  for (const kernel of kernels) ran.add(kernel);
  for (const { what, values, expected } of outputs) {
    assert(values.length > 0 && values.length === expected.length);
    if (what === "positions") checkPositions(floats(values), floats(expected));
    else checkKeys(words(values), words(expected));
  }
  if (picture) checkPicture(picture.pixels, picture.expected);
}
for (const kernel of ["fill_interior", "weigh_strand_tiles", "gather_strand_tiles", "show_strand_tiles"])
  assert(ran.has(kernel), `${kernel} has run`);
process.exit(0);
