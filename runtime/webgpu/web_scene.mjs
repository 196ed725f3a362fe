// Scenes of hair in JavaScript: pelage's core as WebAssembly. wasm_binding.cpp has what it exports.

/**
 * @typedef {{section: string, title: string, path: string, type: string, unit: string, range: string,
 *   meaning: string, choices: string[], slider: [number, number, number], value: number | number[]}}
 *   Parameter
 * @typedef {{eye: [number, number, number], target: [number, number, number], verticalFov: number,
 *   width: number, height: number}} Camera
 */

/** The list of a frame before which the depth of opaque objects is in Scene.depthBuffer. */
export const DEPTH_LIST = 2;

const NOT_SUPPORTED = 58; // of WASI
const STDERR = 2;

/**
 * Functions of the system that the C++ library asks for. Messages go to the console; there are no files.
 * @param {WebAssembly.Module} module
 * @param {() => WebAssembly.Memory} memory
 */
function importsOf(module, memory) {
  /** @type {Record<string, (...values: any[]) => unknown>} */
  const system = {
    /** @param {number} file @param {number} parts @param {number} count @param {number} written */
    fd_write(file, parts, count, written) {
      const view = new DataView(memory().buffer);
      let text = "";
      let bytes = 0;
      for (let i = 0; i < count; ++i) {
        const begin = view.getUint32(parts + 8 * i, true);
        const size = view.getUint32(parts + 8 * i + 4, true);
        text += new TextDecoder().decode(new Uint8Array(memory().buffer, begin, size));
        bytes += size;
      }
      view.setUint32(written, bytes, true);
      if (file === STDERR) console.error(text);
      else console.log(text);
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
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = system[name] ?? (() => NOT_SUPPORTED);
  }
  return imports;
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

  /** The demo's character, which walks. */
  character() {
    return new Scene(this, this.call("character"));
  }

  /**
   * The demo's groom on a head.
   * @param {number} strands
   * @param {number} [seed]
   */
  head(strands, seed = 1) {
    return new Scene(this, this.call("head", strands, seed));
  }

  /**
   * Hair of a .tfx file.
   * @param {Uint8Array} bytes
   */
  hair(bytes) {
    return this.with(bytes, (at) => new Scene(this, this.call("hair", at, bytes.length)));
  }

  /**
   * Calls a function that returns 0 for an error.
   * @param {string} name
   * @param {number[]} values
   */
  call(name, ...values) {
    const result = this.get(name, ...values);
    if (result === 0) throw new Error(this.text(this.get("error")));
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
  frame(seconds, { eye, target, verticalFov, width, height }) {
    const at = this.#core.call("frame", this.#scene, seconds, ...eye, ...target, verticalFov, width, height);
    return this.#core.bytes(at, this.#core.get("frame_bytes"));
  }

  /** Number of the buffer for the depth of opaque objects, a float a pixel; far everywhere at first. */
  get depthBuffer() {
    return this.#core.get("depth_buffer", this.#scene);
  }

  /**
   * Number of the buffer with the positions of a hair object, four floats a vertex.
   * @param {number} hair
   */
  positionsBuffer(hair) {
    return this.#core.call("positions_buffer", this.#scene, hair);
  }

  /** The body as of the last frame: position, normal and color, nine floats a vertex. */
  get body() {
    const count = this.#core.get("body_vertices", this.#scene);
    return new Float32Array(this.#core.bytes(this.#core.get("body", this.#scene), 36 * count).slice().buffer);
  }

  /** Three indices a triangle. */
  get bodyIndices() {
    const count = this.#core.get("body_index_count", this.#scene);
    return new Uint32Array(this.#core.bytes(this.#core.get("body_indices", this.#scene), 4 * count).slice().buffer);
  }

  /** @returns {Parameter[]} */
  get parameters() {
    return JSON.parse(this.#core.text(this.#core.call("parameters", this.#scene)));
  }

  /**
   * Sets a parameter of all hair, or of the light.
   * @param {string} section
   * @param {string} path
   * @param {number[]} values as many as its type has; the index of a choice
   */
  set(section, path, values) {
    const core = this.#core;
    const text = (/** @type {string} */ value) => new TextEncoder().encode(value);
    core.with(text(section), (sectionAt) =>
      core.with(text(path), (pathAt) =>
        core.with(new Uint8Array(new Float64Array(values).buffer), (valuesAt) =>
          core.call("set", this.#scene, sectionAt, pathAt, valuesAt, values.length),
        ),
      ),
    );
  }

  destroy() {
    this.#core.get("free", this.#scene);
    this.#scene = 0;
  }
}
