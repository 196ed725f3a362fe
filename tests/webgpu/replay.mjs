// Runs the recorded frames of a scene: record_scene.cpp has the form.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { Executor, readFrame } from "./executor.mjs";
import { readBuffer, readPicture } from "./readback.mjs";

const COLOR = "rgba16float";

/**
 * @param {GPUDevice} device
 * @param {import("./executor.mjs").Variant[]} variants
 * @param {string} folder
 * @returns {Promise<{outputs: {what: string, values: Uint8Array, expected: Uint8Array}[],
 *   picture: {pixels: Float32Array, expected: Float32Array} | null, kernels: Set<string>}>}
 */
export async function replay(device, variants, folder) {
  const scene = JSON.parse(readFileSync(join(folder, "scene.json"), "utf8"));
  const bytes = readFileSync(join(folder, "scene.bin"));
  const names = new Map(variants.map(({ hash, kernel }) => [hash, kernel]));
  const kernels = new Set();
  const executor = new Executor(device, variants);
  const { width, height } = scene.picture ?? { width: 1, height: 1 };
  const picture = device.createTexture({
    size: [width, height],
    format: COLOR,
    usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC,
  });
  const target = { color: picture.createView(), colorFormat: COLOR };
  for (const { offset, size } of scene.frames) {
    const memory = bytes.subarray(offset, offset + size);
    for (const { passes } of readFrame(memory).lists)
      for (const { kernel, pixel } of passes) for (const hash of [kernel, pixel]) kernels.add(names.get(hash));
    executor.run(memory, target);
    await device.queue.onSubmittedWorkDone();
  }

  const at = (offset, size) => new Uint8Array(bytes.subarray(offset, offset + size));
  const outputs = [];
  for (const { what, buffer, expected, size } of scene.outputs) {
    const values = await readBuffer(device, executor.buffer(buffer), size);
    outputs.push({ what, values, expected: at(expected, size) });
  }
  const pixels = scene.picture && (await readPicture(device, picture));
  executor.destroy();
  return {
    outputs,
    picture: pixels && {
      pixels,
      expected: new Float32Array(at(scene.picture.expected, 16 * width * height).buffer),
    },
    kernels,
  };
}
