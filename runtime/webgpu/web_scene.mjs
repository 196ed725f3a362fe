// Scenes of hair in JavaScript: pelage's core as WebAssembly. wasm/binding.cpp has what it exports.

/**
 * @typedef {{section: string, title: string, path: string, type: string, unit: string, range:
 * string, meaning: string, choices: string[], slider: [number, number, number], value: number |
 * number[]}} Parameter
 * @typedef {{eye: [number, number, number], target: [number, number, number], verticalFov: number,
 *   width: number, height: number}} Camera
 */

/** The list of a frame before which the depth of opaque objects is in Scene.depthBuffer. */
export const DEPTH_LIST = 3;
/** Bytes of Scene.countersBuffer that Scene.takeCounters() wants. */
export const COUNTER_BYTES = 32;
/** Of heads, in the order of GroomPreset. */
export const GROOMS = ["parted", "straight", "curly", "fur", "mohawk"];

const OF_GROOM = 0xffffffff;

const NOT_SUPPORTED = 58;  // of WASI
const STDERR = 2;

/**
 * Functions of the system that the C++ library asks for. Messages go to the console; there are no
 * files.
 * @param {WebAssembly.Module} module
 * @param {() => WebAssembly.Memory} memory
 */
function importsOf(module, memory) {
  /** @type {Record<string, (...values: any[]) => unknown>} */
  const system = {
    /** @param {number} file @param {number} parts @param {number} count @param {number} written */
    fd_write(file, parts, count, written) {
      const view = new DataView(memory().buffer);
      let text = '';
      let bytes = 0;
      for (let i = 0; i < count; ++i) {
        const begin = view.getUint32(parts + 8 * i, true);
        const size = view.getUint32(parts + 8 * i + 4, true);
        text += new TextDecoder().decode(new Uint8Array(memory().buffer, begin, size));
        bytes += size;
      }
      view.setUint32(written, bytes, true);
      if (file === STDERR)
        console.error(text);
      else
        console.log(text);
      return 0;
    },
    /** @param {number} _clock @param {bigint} _precision @param {number} time */
    clock_time_get(_clock, _precision, time) {
      const nanoseconds = BigInt(Math.round(1e6 * performance.now()));
      new DataView(memory().buffer).setBigUint64(time, nanoseconds, true);
      return 0;
    },
    /** @param {number} code */
    proc_exit(code) {
      throw new Error(`pelage's core has ended with ${code}`);
    },
    emscripten_notify_memory_growth() {},
  };
  /** @type {Record<string, Record<string, WebAssembly.ImportValue>>} */
  const imports = {};
  for (const {module: from, name} of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = system[name] ?? (() => NOT_SUPPORTED);
  }
  return imports;
}

/** @param {string} value */
function text(value) {
  return new TextEncoder().encode(value);
}

/** The core: makes scenes. */
export class Core {
  /** @type {Record<string, (...values: number[]) => number>} */
  #calls;
  /** @type {WebAssembly.Memory} */
  #memory;

  /** @param {WebAssembly.Instance} instance */
  constructor(instance) {
    this.#calls = /** @type {any} */ (instance.exports);
    this.#memory = /** @type {WebAssembly.Memory} */ (instance.exports.memory);
  }

  /**
   * @param {BufferSource} bytes of pelage.wasm
   * @returns {Promise<Core>}
   */
  static async load(bytes) {
    const module = await WebAssembly.compile(bytes);
    /** @type {WebAssembly.Instance} */
    let instance;
    instance = await WebAssembly.instantiate(
        module,
        importsOf(module, () => /** @type {WebAssembly.Memory} */ (instance.exports.memory)),
    );
    /** @type {any} */ (instance.exports)._initialize?.();
    return new Core(instance);
  }

  /** The demo's character, which walks, shakes its head and jumps. */
  character() {
    return new Scene(this, this.call('character'));
  }

  /**
   * A groom of the gallery on a head; numbers that are not given are those of the groom.
   * @param {{groom?: string, strands?: number, follow?: number, seed?: number}} [def] groom of
   *   GROOMS, guides, follow hairs a guide
   */
  head({ groom = "parted", strands = OF_GROOM, follow = OF_GROOM, seed = 1 } = {}) {
    const index = GROOMS.indexOf(groom);
    if (index < 0) throw new Error(`there is no groom '${groom}'; there are: ${GROOMS.join(", ")}`);
    return new Scene(this, this.call("head", index, strands, follow, seed));
  }

  /**
   * Hair of a .tfx file.
   * @param {Uint8Array} bytes
   */
  hair(bytes) {
    return this.with(bytes, (at) => new Scene(this, this.call('hair', at, bytes.length)));
  }

  /** @returns {{name: string, meaning: string}[]} */
  get presets() {
    return JSON.parse(this.text(this.get("presets")));
  }

  /**
   * Calls a function that returns 0 for an error.
   * @param {string} name
   * @param {number[]} values
   */
  call(name, ...values) {
    const result = this.get(name, ...values);
    if (result === 0) throw new Error(this.text(this.get('error')));
    return result;
  }

  /** @param {string} name @param {number[]} values */
  get(name, ...values) {
    return this.#calls[`pelage_web_${name}`](...values) >>> 0;
  }

  /**
   * Bytes of the core, until the next call.
   * @param {number} at
   * @param {number} size
   */
  bytes(at, size) {
    return new Uint8Array(this.#memory.buffer, at, size);
  }

  /** @param {number} at of a text that ends with 0 */
  text(at) {
    const all = new Uint8Array(this.#memory.buffer);
    return new TextDecoder().decode(all.subarray(at, all.indexOf(0, at)));
  }

  /**
   * Gives the core bytes for the length of a call.
   * @template T
   * @param {Uint8Array} bytes
   * @param {(at: number) => T} work
   * @returns {T}
   */
  with(bytes, work) {
    const at = this.#calls.malloc(bytes.length + 1) >>> 0;
    if (at === 0) throw new Error(`there is no memory for ${bytes.length} bytes`);
    this.bytes(at, bytes.length).set(bytes);
    this.bytes(at, bytes.length + 1)[bytes.length] = 0;
    try {
      return work(at);
    } finally {
      this.#calls.free(at);
    }
  }
}

/** Hair and what it grows on. */
export class Scene {
  #core;
  #scene;

  /**
   * @param {Core} core
   * @param {number} scene
   */
  constructor(core, scene) {
    this.#core = core;
    this.#scene = scene;
  }

  /**
   * Simulates and draws the next frame, for Executor.run().
   * @param {number} seconds
   * @param {Camera} camera
   * @returns {Uint8Array} until the next call
   */
  frame(seconds, {eye, target, verticalFov, width, height}) {
    const at = this.#core.call(
        'frame', this.#scene, seconds, ...eye, ...target, verticalFov, width, height);
    return this.#core.bytes(at, this.#core.get('frame_bytes'));
  }

  /**
   * Number of the buffer for the depth of opaque objects, a float a pixel; far everywhere at
   * first.
   */
  get depthBuffer() {
    return this.#core.get('depth_buffer', this.#scene);
  }

  /** Number of the buffer that counts the fragments of the last frame; 0 before the first. */
  get countersBuffer() {
    return this.#core.get("counters_buffer", this.#scene);
  }

  /**
   * Makes room for as many fragments as a frame had: tiles without room are empty.
   * @param {Uint8Array} counters first COUNTER_BYTES of its countersBuffer, at the current size
   */
  takeCounters(counters) {
    this.#core.with(counters, (at) => this.#core.call("take_counters", this.#scene, at, counters.length));
  }

  /**
   * A camera that sees all of the scene in every pose.
   * @param {number} aspect width over height
   * @returns {Omit<Camera, "width" | "height">}
   */
  camera(aspect) {
    const bytes = this.#core.bytes(this.#core.get("camera", this.#scene, aspect), 28);
    const [x, y, z, targetX, targetY, targetZ, verticalFov] = new Float32Array(bytes.slice().buffer);
    return { eye: [x, y, z], target: [targetX, targetY, targetZ], verticalFov };
  }

  /** Number of hair objects. */
  get hairs() {
    return this.#core.get("hairs", this.#scene);
  }

  /**
   * Number of the buffer with the positions of a hair object, four floats a vertex: guides come first.
   * @param {number} hair
   */
  positionsBuffer(hair) {
    return this.#core.call("positions_buffer", this.#scene, hair);
  }

  /**
   * Bytes of the guides' positions.
   * @param {number} hair
   */
  guideBytes(hair) {
    return this.#core.get("guide_bytes", this.#scene, hair);
  }

  /**
   * Takes the lock of hair at a pixel of the last frame, for dragTo().
   * @param {number} x pixels from the left
   * @param {number} y pixels from the top
   * @param {Uint8Array} guides the guides' positions of each hair object, one behind the other
   * @returns {boolean} whether hair is there
   */
  pull(x, y, guides) {
    return this.#core.with(guides, (at) => this.#core.call("pull", this.#scene, x, y, at, guides.length)) === 2;
  }

  /**
   * Drags the lock to a pixel.
   * @param {number} x
   * @param {number} y
   */
  dragTo(x, y) {
    this.#core.get("drag_to", this.#scene, x, y);
  }

  /** Releases the lock. */
  release() {
    this.#core.get("release", this.#scene);
  }

  /** @returns {Parameter[]} */
  get parameters() {
    return JSON.parse(this.#core.text(this.#core.call('parameters', this.#scene)));
  }

  /**
   * Sets a parameter of all hair, or of the light.
   * @param {string} section
   * @param {string} path
   * @param {number[]} values as many as its type has; the index of a choice
   */
  set(section, path, values) {
    const core = this.#core;
    core.with(
        text(section),
        (sectionAt) => core.with(
            text(path),
            (pathAt) => core.with(
                new Uint8Array(new Float64Array(values).buffer),
                (valuesAt) =>
                    core.call('set', this.#scene, sectionAt, pathAt, valuesAt, values.length),
                ),
            ),
    );
  }

  /**
   * Gives all hair the simulation, the material and the follow hairs of a preset; hair is then in its
   * bind shape.
   * @param {string} name of Core.presets
   */
  takePreset(name) {
    this.#core.with(text(name), (at) => this.#core.call("take_preset", this.#scene, at));
  }

  destroy() {
    this.#core.get('free', this.#scene);
    this.#scene = 0;
  }
}
