// Runs the recorded frames of a scene: record_scene.cpp has the form.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { Executor, readFrame } from "./executor.mjs";

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

  async function read(size, copy) {
    const mapped = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = device.createCommandEncoder();
    copy(encoder, mapped);
    device.queue.submit([encoder.finish()]);
    await mapped.mapAsync(GPUMapMode.READ);
    return new Uint8Array(mapped.getMappedRange().slice(0));
  }
  const at = (offset, size) => new Uint8Array(bytes.subarray(offset, offset + size));
  const outputs = [];
  for (const { what, buffer, expected, size } of scene.outputs) {
    const values = await read(size, (encoder, mapped) =>
      encoder.copyBufferToBuffer(executor.buffer(buffer), 0, mapped, 0, size),
    );
    outputs.push({ what, values, expected: at(expected, size) });
  }
  const halves =
    scene.picture &&
    (await read(8 * width * height, (encoder, buffer) =>
      encoder.copyTextureToBuffer({ texture: picture }, { buffer, bytesPerRow: 8 * width }, [width, height]),
    ));
  executor.destroy();
  return {
    outputs,
    picture: halves && {
      pixels: floatsOf(new Uint16Array(halves.buffer)),
      expected: new Float32Array(at(scene.picture.expected, 16 * width * height).buffer),
    },
    kernels,
  };
}

/** @param {Uint16Array} halves @returns {Float32Array} */
function floatsOf(halves) {
  return Float32Array.from(halves, (half) => {
    const sign = half & 0x8000 ? -1 : 1;
    const exponent = (half >> 10) & 31;
    const fraction = half & 1023;
    if (exponent === 31) return fraction ? NaN : sign * Infinity;
    return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : (2 ** -14 * fraction) / 1024);
  });
}
