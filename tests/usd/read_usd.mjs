// Reads .usda files with tinyusdz, which knows nothing of pelage, and compares what it prints with
// the numbers that were written: read_usd.mjs FOLDER, where write_usd has put them.
import assert from 'node:assert';
import { copyFileSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const folder = process.argv[2];
const require = createRequire(import.meta.url);

// The package is built for browsers: it refuses Node by name, but needs nothing that Node lacks.
async function loadTinyUsdz() {
  const directory = join(require.resolve('tinyusdz'), '..');
  // Node.js 18 takes a .js file of this package for CommonJS.
  const module = join(directory, 'tinyusdz.mjs');
  copyFileSync(join(directory, 'tinyusdz.js'), module);
  process.type = 'renderer';
  globalThis.window = globalThis;
  const { default: make } = await import(pathToFileURL(module));
  return make({ wasmBinary: readFileSync(join(directory, 'tinyusdz.wasm')) });
}

const tinyusdz = await loadTinyUsdz();

// The text that the reader prints of a file, after it has also taken it for a stage of typed prims.
function read(name) {
  const bytes = readFileSync(join(folder, name));
  const stage = new tinyusdz.TinyUSDZLoaderNative();
  assert.ok(stage.loadFromBinary(bytes, name) && stage.ok(), `${name}: ${stage.error()}`);
  const layer = new tinyusdz.TinyUSDZLoaderNative();
  assert.ok(layer.loadAsLayerFromBinary(bytes, name) && layer.ok(), `${name}: ${layer.error()}`);
  return layer.layerToString();
}

const numbersIn = (text) => (text.match(/-?[0-9.]+(?:e[-+]?[0-9]+)?/g) ?? []).map(Number);

function valueOf(text, declaration) {
  const found = text.split('\n').find((line) => line.trim().startsWith(`${declaration} = `));
  assert.ok(found, `no ${declaration}`);
  return found.slice(found.indexOf('=') + 1).replace(/\($/, '').trim();
}

// time -> numbers
function samplesOf(text, declaration) {
  const begin = text.indexOf(`${declaration}.timeSamples = {`);
  assert.ok(begin >= 0, `no samples of ${declaration}`);
  const lines = text.slice(begin, text.indexOf('}', begin)).split('\n').slice(1);
  return new Map(lines.filter((line) => line.includes(':')).map((line) => {
    const colon = line.indexOf(':');
    return [Number(line.slice(0, colon)), numbersIn(line.slice(colon + 1))];
  }));
}

// tinyusdz prints floats with a unit or two in their last digit.
function assertClose(actual, expected, what) {
  assert.strictEqual(actual.length, expected.length, what);
  actual.forEach((value, i) => {
    const error = Math.abs(value - expected[i]);
    assert.ok(error <= 5e-7 * Math.abs(expected[i]) + 1e-12, `${what}[${i}]: ${value}, ${expected[i]}`);
  });
}

const expected = JSON.parse(readFileSync(join(folder, 'expected.json'), 'utf8'));

function checkLayer(text, first, last) {
  assert.strictEqual(Number(valueOf(text, 'startTimeCode')), first);
  assert.strictEqual(Number(valueOf(text, 'endTimeCode')), last);
  assert.strictEqual(Number(valueOf(text, 'timeCodesPerSecond')), expected.framesPerSecond);
  assert.strictEqual(Number(valueOf(text, 'metersPerUnit')), 1);
  assert.strictEqual(valueOf(text, 'upAxis'), '"Y"');
  assert.strictEqual(valueOf(text, 'defaultPrim'), '"hair"');
  assert.match(text, /def BasisCurves "hair"/);
  assert.deepStrictEqual(numbersIn(valueOf(text, 'int[] curveVertexCounts')), expected.vertexCounts);
  assert.strictEqual(valueOf(text, 'uniform token type'), '"linear"');
  assertClose(numbersIn(valueOf(text, 'float[] widths')), expected.widths, 'widths');
  assert.deepStrictEqual(numbersIn(valueOf(text, 'int64[] primvars:id')), expected.ids);
}

function checkFrames(text, first, count) {
  const points = samplesOf(text, 'point3f[] points');
  const velocities = samplesOf(text, 'vector3f[] velocities');
  const extents = samplesOf(text, 'float3[] extent');
  for (const samples of [points, velocities, extents]) assert.strictEqual(samples.size, count);
  for (let f = first; f < first + count; ++f) {
    const at = (frame) => expected.points[frame - expected.firstFrame];
    assertClose(points.get(f), at(f), `points of frame ${f}`);
    const from = Math.max(f - 1, first), to = Math.min(f + 1, first + count - 1);
    const perSecond = expected.framesPerSecond / Math.max(to - from, 1);
    const speed = at(f).map((_, i) => Math.fround((at(to)[i] - at(from)[i]) * perSecond));
    assertClose(velocities.get(f), speed, `velocities of frame ${f}`);
    const radius = Math.max(...expected.widths) / 2;
    const axis = (k) => at(f).filter((_, i) => i % 3 === k);
    const box = [0, 1, 2].map((k) => Math.min(...axis(k)) - radius)
      .concat([0, 1, 2].map((k) => Math.max(...axis(k)) + radius));
    assertClose(extents.get(f), box, `extent of frame ${f}`);
  }
}

const first = expected.firstFrame, count = expected.points.length;
const shot = read('shot.usda');
checkLayer(shot, first, first + count - 1);
checkFrames(shot, first, count);

// The parts, and the root file that shows them.
const root = read('clips.usda');
checkLayer(root, first, first + count - 1);
assert.deepStrictEqual(numbersIn(valueOf(root, 'double2[] active')), [first, 0, first + 2, 1]);
assert.deepStrictEqual(valueOf(root, 'asset[] assetPaths'), '[@./part0.usda@, @./part1.usda@]');
assert.deepStrictEqual(numbersIn(valueOf(root, 'double2[] times')),
  [first, first, first + count - 1, first + count - 1]);
assert.strictEqual(valueOf(root, 'string primPath'), '"/hair"');
checkFrames(read('part0.usda'), first, 2);
checkFrames(read('part1.usda'), first + 2, count - 2);
assert.match(read('clips.manifest.usda'), /over "hair"/);

// Curves that are no shot, with Unreal's names.
const groom = read('groom.usda');
assert.strictEqual(Number(valueOf(groom, 'metersPerUnit')), 1);
assert.deepStrictEqual(numbersIn(valueOf(groom, 'int[] curveVertexCounts')), expected.vertexCounts);
assertClose(numbersIn(valueOf(groom, 'point3f[] points')), expected.points[0], 'points of the groom');
assert.strictEqual(numbersIn(valueOf(groom, 'float[] widths')).length, expected.points[0].length / 3);
assert.deepStrictEqual(numbersIn(valueOf(groom, 'int64[] primvars:groom_id')), expected.ids);
assert.deepStrictEqual(numbersIn(valueOf(groom, 'int[] primvars:groom_guide')), [1, 0, 1]);
assert.deepStrictEqual(numbersIn(valueOf(groom, 'int[] primvars:groom_group_id')), [0, 3, 3]);
assertClose(numbersIn(valueOf(groom, 'float2[] primvars:groom_root_uv')), [0, 0.5, 0.25, 1, 1, 0], 'root UV');
console.log(`${count} frames and 2 clips are as they were written`);
