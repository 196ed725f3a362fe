// Writes pictures as PNG.
import { writeFileSync } from "node:fs";
import { crc32, deflateSync } from "node:zlib";

/** @param {string} name @param {Uint8Array} data */
function chunk(name, data) {
  const bytes = Buffer.concat([Buffer.alloc(4), Buffer.from(name), data, Buffer.alloc(4)]);
  bytes.writeUInt32BE(data.length, 0);
  bytes.writeUInt32BE(crc32(bytes.subarray(4, bytes.length - 4)), bytes.length - 4);
  return bytes;
}

/**
 * @param {string} path
 * @param {number} width
 * @param {number} height
 * @param {Uint8Array} pixels RGBA, encoded as sRGB; alpha is left out
 */
export function writePng(path, width, height, pixels) {
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 2], 8); // bits a channel, RGB
  const rows = Buffer.alloc(height * (1 + 3 * width));
  for (let i = 0; i < width * height; ++i)
    rows.set(pixels.subarray(4 * i, 4 * i + 3), Math.floor(i / width) * (1 + 3 * width) + 1 + 3 * (i % width));
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  const parts = [chunk("IHDR", head), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))];
  writeFileSync(path, Buffer.concat([signature, ...parts]));
}
