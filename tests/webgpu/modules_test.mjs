// Every WGSL module is one that WebGPU takes, and every compute kernel makes a pipeline with the
// bindings of the reflection: node modules_test.mjs REFLECTION
import assert from "node:assert";
import { testDevice } from "./device.mjs";
import { readKernels } from "./kernels.mjs";

const { variants, missing } = readKernels(process.argv[2]);
const device = await testDevice();
const { bindGroupLayouts } = await import("./executor.mjs");

/** @returns {Promise<string>} what WebGPU says against it */
async function errorOf(work) {
  device.pushErrorScope("validation");
  work();
  return (await device.popErrorScope())?.message ?? "";
}

async function pipelineError(variant, layouts = bindGroupLayouts(device, [variant])) {
  return errorOf(() =>
    device.createComputePipeline({
      layout: device.createPipelineLayout({ bindGroupLayouts: layouts }),
      compute: { module: device.createShaderModule({ code: variant.code }), entryPoint: variant.kernel },
    }),
  );
}

const errors = [];
let pipelines = 0;
for (const variant of variants) {
  let error = await errorOf(() => device.createShaderModule({ code: variant.code }));
  if (!error && variant.stage === "compute") {
    error = await pipelineError(variant);
    ++pipelines;
  }
  if (error) errors.push(`${variant.kernel} ${variant.key}: ${error}`);
}
assert.deepEqual(errors, []);
assert(pipelines > 0 && pipelines < variants.length);

// The check notices what is wrong: a module that does not parse, a binding of the other access.
assert.notEqual(await errorOf(() => device.createShaderModule({ code: "fn (" })), "");
const written = variants.find(
  ({ stage, bindings }) => stage === "compute" && bindings.some(({ access }) => access !== "read"),
);
const readOnly = { ...written, bindings: written.bindings.map((b) => ({ ...b, access: "read" })) };
assert.notEqual(await pipelineError(written, bindGroupLayouts(device, [readOnly])), "");

console.log(`${variants.length} modules, ${pipelines} compute pipelines, ${missing.length} not there`);
process.exit(0);
