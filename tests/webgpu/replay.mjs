// Runs the recorded lists of a scene: record_scene.cpp has the form.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { bindGroupLayouts } from "./kernels.mjs";

const STORAGE = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC;

/**
 * @param {GPUDevice} device
 * @param {import("./kernels.mjs").Variant[]} variants
 * @param {string} folder
 * @returns {Promise<{positions: Float32Array, expected: Float32Array, kernels: Set<string>}>}
 */
export async function replay(device, variants, folder) {
  const scene = JSON.parse(readFileSync(join(folder, "scene.json"), "utf8"));
  const bytes = readFileSync(join(folder, "scene.bin"));
  const byHash = new Map(variants.map((variant) => [variant.hash, variant]));
  const buffers = new Map();
  const pipelines = new Map();

  function pipelineOf(pass) {
    if (pipelines.has(pass.hash)) return pipelines.get(pass.hash);
    const variant = byHash.get(pass.hash);
    if (!variant) throw new Error(`no WGSL of ${pass.kernel}`);
    const layouts = bindGroupLayouts(device, variant);
    const pipeline = device.createComputePipeline({
      layout: device.createPipelineLayout({ bindGroupLayouts: layouts }),
      compute: { module: device.createShaderModule({ code: variant.code }), entryPoint: variant.kernel },
    });
    pipelines.set(pass.hash, { pipeline, layouts });
    return pipelines.get(pass.hash);
  }

  // A constant block is a buffer of its own, for the length of a list.
  function resourceOf(binding, blocks) {
    if (binding.buffer) return { buffer: buffers.get(binding.buffer), offset: binding.offset, size: binding.size };
    const buffer = device.createBuffer({ size: binding.size, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    device.queue.writeBuffer(buffer, 0, bytes, binding.offset, binding.size);
    blocks.push(buffer);
    return { buffer };
  }

  for (const frame of scene.frames) {
    for (const { id, name, size, initial } of frame.buffers) {
      const buffer = device.createBuffer({ label: name, size, usage: STORAGE });
      if (initial !== undefined) device.queue.writeBuffer(buffer, 0, bytes, initial, size);
      buffers.set(id, buffer);
    }
    for (const list of frame.lists) {
      for (const { buffer, offset, data, size } of list.uploads)
        device.queue.writeBuffer(buffers.get(buffer), offset, bytes, data, size);
      const blocks = [];
      const encoder = device.createCommandEncoder();
      let pass = encoder.beginComputePass();
      for (const entry of list.passes) {
        // A dispatch may not write the buffer that has its counts: they are copied out of it.
        let counts;
        if (entry.indirect) {
          counts = device.createBuffer({ size: 12, usage: GPUBufferUsage.INDIRECT | GPUBufferUsage.COPY_DST });
          blocks.push(counts);
          pass.end();
          encoder.copyBufferToBuffer(buffers.get(entry.indirect), entry.indirectOffset, counts, 0, 12);
          pass = encoder.beginComputePass();
        }
        const { pipeline, layouts } = pipelineOf(entry);
        pass.setPipeline(pipeline);
        layouts.forEach((layout, set) => {
          const entries = entry.bindings
            .filter((binding) => binding.set === set)
            .map((binding) => ({ binding: binding.entry, resource: resourceOf(binding, blocks) }));
          pass.setBindGroup(set, device.createBindGroup({ layout, entries }));
        });
        if (counts) pass.dispatchWorkgroupsIndirect(counts, 0);
        else pass.dispatchWorkgroups(...entry.groups);
      }
      pass.end();
      device.queue.submit([encoder.finish()]);
      await device.queue.onSubmittedWorkDone();
      for (const block of blocks) block.destroy();
    }
  }

  const size = scene.expectedSize;
  const target = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  const encoder = device.createCommandEncoder();
  encoder.copyBufferToBuffer(buffers.get(scene.positions), 0, target, 0, size);
  device.queue.submit([encoder.finish()]);
  await target.mapAsync(GPUMapMode.READ);
  const kernels = new Set(scene.frames.flatMap(({ lists }) => lists.flatMap(({ passes }) => passes.map((p) => p.kernel))));
  const at = (offset) => new Float32Array(bytes.buffer.slice(bytes.byteOffset + offset, bytes.byteOffset + offset + size));
  return {
    positions: new Float32Array(target.getMappedRange().slice(0)),
    expected: at(scene.expected),
    kernels,
  };
}
