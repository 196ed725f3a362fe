// Hair on WebGPU is where it is on Vulkan: node scene_test.mjs REFLECTION FOLDER
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

for (const name of ["exact", "contacts", "classic"]) {
  const { positions, expected, kernels } = await replay(device, variants, join(process.argv[3], name));
  assert.deepEqual(errors, []);
  assert(positions.length > 0 && positions.length === expected.length);
  const distances = distancesOf(positions, expected);
  const sum = positions.reduce((total, value, i) => total + (i % 4 === 0 ? value : 0), 0);
  assert((4 * sum) / positions.length > 0.5, "the hair is where its bone has gone, by 1 m along x");
  const median = 1000 * distances[distances.length >> 1];
  const most = 1000 * distances[distances.length - 1];
  const equal = distances.filter((d) => d === 0).length;
  console.log(
    `${name}: ${[...kernels].join(", ")}\n  ${distances.length} vertices, ${equal} with the same bits, ` +
      `median ${median} mm, maximum ${most} mm`,
  );
  assert(median <= 0.1, "the median vertex is within 0.1 mm");
}
process.exit(0);
