// Hair on WebGPU is where it is on Vulkan, and looks like it: node scene_test.mjs REFLECTION FOLDER
import assert from "node:assert";
import { join } from "node:path";
import { testDevice } from "./device.mjs";
import { readKernels } from "./kernels.mjs";
import { checkPicture, checkPositions } from "./readback.mjs";

const { variants } = readKernels(process.argv[2]);
const device = await testDevice();
const { replay } = await import("./replay.mjs");
const errors = [];
device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));

function checkMoved(positions) {
  const sum = positions.reduce((total, value, i) => total + (i % 4 === 0 ? value : 0), 0);
  assert((4 * sum) / positions.length > 0.5, "the hair is where its bone has gone, by 1 m along x");
}

// Distances that are quantized, with a triangle of equal distance where there are several.
function checkKeys(keys, expected) {
  const equal = keys.reduce((count, key, i) => count + (key === expected[i] ? 1 : 0), 0);
  console.log(`  ${keys.length} keys of the SDF, ${equal} with the same bits`);
  assert(equal >= 0.99 * keys.length);
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
    if (what === "positions") {
      checkPositions(floats(values), floats(expected));
      checkMoved(floats(values));
    } else checkKeys(words(values), words(expected));
  }
  if (picture) checkPicture(picture.pixels, picture.expected);
}
for (const kernel of ["fill_interior", "weigh_strand_tiles", "gather_strand_tiles", "show_strand_tiles"])
  assert(ran.has(kernel), `${kernel} has run`);
process.exit(0);
