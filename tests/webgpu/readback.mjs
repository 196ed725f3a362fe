// Reads results of WebGPU back, and compares them with those of another device.
import assert from "node:assert";

/**
 * @param {GPUDevice} device
 * @param {number} size
 * @param {(encoder: GPUCommandEncoder, mapped: GPUBuffer) => void} copy
 * @returns {Promise<Uint8Array>}
 */
async function read(device, size, copy) {
  const mapped = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  const encoder = device.createCommandEncoder();
  copy(encoder, mapped);
  device.queue.submit([encoder.finish()]);
  await mapped.mapAsync(GPUMapMode.READ);
  return new Uint8Array(mapped.getMappedRange().slice(0));
}

/** @param {GPUDevice} device @param {GPUBuffer} buffer @param {number} size */
export function readBuffer(device, buffer, size = buffer.size) {
  return read(device, size, (encoder, mapped) => encoder.copyBufferToBuffer(buffer, 0, mapped, 0, size));
}

/**
 * @param {GPUDevice} device
 * @param {GPUTexture} texture with rows of a multiple of 256 bytes
 * @param {number} bytes of a pixel
 */
export function readTexture(device, texture, bytes) {
  const { width, height } = texture;
  return read(device, bytes * width * height, (encoder, buffer) =>
    encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: bytes * width }, [width, height]),
  );
}

/**
 * @param {GPUDevice} device
 * @param {GPUTexture} texture of rgba16float, with a width that is a multiple of 32
 * @returns {Promise<Float32Array>} four a pixel
 */
export async function readPicture(device, texture) {
  return floatsOf(new Uint16Array((await readTexture(device, texture, 8)).buffer));
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

/**
 * Checks that vertices are within 0.1 mm of where they are expected, in the median, and 99 of 100 within
 * 1 mm: contacts are decisions, after which a last bit becomes millimeters.
 * @param {Float32Array} positions four a vertex
 * @param {Float32Array} expected
 */
export function checkPositions(positions, expected) {
  assert(positions.length > 0 && positions.length === expected.length);
  const distances = [];
  for (let i = 0; i < positions.length; i += 4)
    distances.push(Math.hypot(...[0, 1, 2].map((axis) => positions[i + axis] - expected[i + axis])));
  assert(distances.every(Number.isFinite));
  distances.sort((a, b) => a - b);
  const median = 1000 * distances[distances.length >> 1];
  const most = 1000 * distances[distances.length - 1];
  const equal = distances.filter((d) => d === 0).length;
  const nearly = 1000 * distances[Math.floor(0.99 * distances.length)];
  console.log(
    `  ${distances.length} vertices, ${equal} with the same bits, median ${median} mm, 99 % within ${nearly} mm, maximum ${most} mm`,
  );
  assert(median <= 0.1, "the median vertex is within 0.1 mm");
  assert(nearly <= 1, "99 of 100 vertices are within 1 mm");
}

/**
 * Checks that a picture shows hair, and is the expected one to 50 dB.
 * @param {Float32Array} pixels
 * @param {Float32Array} expected
 */
export function checkPicture(pixels, expected) {
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
