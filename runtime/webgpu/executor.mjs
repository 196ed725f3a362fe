// Runs the frames of pelage's core on WebGPU. frame_words.h has their form.

/**
 * A resource that a permutation of a kernel uses.
 * @typedef {{set: number, entry: number, name: string, access: string, kind: string}} Binding
 */
/**
 * @typedef {{location: number, type: string, components: number, offset: number}} Attribute
 * @typedef {{step: GPUVertexStepMode, stride: number, attributes: Attribute[]}} VertexInput
 */
/**
 * A permutation of a kernel.
 * @typedef {{kernel: string, stage: string, hash: string, sets: number, bindings: Binding[],
 *   code: string, vertexInput?: VertexInput}} Variant
 */
/**
 * What draws go into. Its pixels stay: clear them before.
 * @typedef {{color: GPUTextureView, colorFormat: GPUTextureFormat, depth?: GPUTextureView,
 *   depthFormat?: GPUTextureFormat}} Target
 */
/**
 * @typedef {{set: number, entry: number, buffer: number, offset: number, size: number}} Bound
 * @typedef {{kind: number, kernel: string, pixel: string, groups: number[], counts: number,
 *   countsOffset: number, vertices: number, verticesOffset: number, verticesSize: number,
 *   indices: number, elements: number, instances: number, state: number, bindings: Bound[]}} Pass
 * @typedef {{buffer: number, offset: number, data: number, size: number}} Upload
 * @typedef {{uploads: Upload[], passes: Pass[], constants: number, constantsSize: number,
 *   area: {x: number, y: number, width: number, height: number}}} List
 * @typedef {{added: {buffer: number, size: number, usage: number, initial: number}[],
 *   removed: number[], lists: List[], bytes: Uint8Array<ArrayBuffer>}} Frame
 */

export const FRAME_VERSION = 0x70656c01;

const [DISPATCH, DISPATCH_INDIRECT, DRAW] = [0, 1, 2];
const INDEX = 2; // of BufferUsage
const INDIRECT = 4;
const VERTEX = 32;
const NO_PIXEL = "0000000000000000";

/** @type {GPUPrimitiveTopology[]} */
const TOPOLOGIES = ["triangle-list", "triangle-strip", "line-list"];
/** @type {GPUCompareFunction[]} */
const COMPARES = ["always", "less", "less-equal", "greater", "greater-equal", "equal"];

/**
 * Reads a frame that FrameWriter has written.
 * @param {Uint8Array} memory
 * @returns {Frame}
 */
export function readFrame(memory) {
  const copy = new Uint8Array(memory);
  const words = new Uint32Array(copy.buffer, 0, copy.length >> 2);
  let at = 0;
  const next = () => {
    if (at >= words.length) throw new Error("a frame ends early");
    return words[at++];
  };
  /** @template T @param {number} count @param {() => T} read @returns {T[]} */
  const many = (count, read) => Array.from({ length: count }, read);
  const hash = () => {
    const low = next();
    return (BigInt(next()) * 2n ** 32n + BigInt(low)).toString(16).padStart(16, "0");
  };
  if (next() !== FRAME_VERSION) throw new Error("a frame of another version of pelage");
  const bytes = copy.subarray(next());
  const [addedCount, removedCount, listCount] = many(3, next);
  const bound = () => ({ set: next(), entry: next(), buffer: next(), offset: next(), size: next() });
  const pass = () => {
    const head = {
      kind: next(),
      kernel: hash(),
      pixel: hash(),
      groups: many(3, next),
      counts: next(),
      countsOffset: next(),
      vertices: next(),
      verticesOffset: next(),
      verticesSize: next(),
      indices: next(),
      elements: next(),
      instances: next(),
      state: next(),
    };
    return { ...head, bindings: many(next(), bound) };
  };
  const list = () => {
    const [uploadCount, passCount, constants, constantsSize] = many(4, next);
    const area = { x: next(), y: next(), width: next(), height: next() };
    const uploads = many(uploadCount, () => ({ buffer: next(), offset: next(), data: next(), size: next() }));
    return { constants, constantsSize, area, uploads, passes: many(passCount, pass) };
  };
  return {
    added: many(addedCount, () => ({ buffer: next(), size: next(), usage: next(), initial: next() })),
    removed: many(removedCount, next),
    lists: many(listCount, list),
    bytes,
  };
}

/** Runs frames of one scene on one device, in their order. */
export class Executor {
  /** @type {GPUDevice} */
  #device;
  /** @type {Map<string, Variant>} */
  #variants;
  /** @type {Map<number, GPUBuffer>} */
  #buffers = new Map();
  /** @type {Map<string, GPUShaderModule>} */
  #modules = new Map();
  /** @type {Map<string, {pipeline: GPUComputePipeline, layouts: GPUBindGroupLayout[]}>} */
  #dispatches = new Map();
  /** @type {Map<string, {pipeline: GPURenderPipeline, layouts: GPUBindGroupLayout[]}>} */
  #draws = new Map();

  /**
   * @param {GPUDevice} device
   * @param {Iterable<Variant>} variants all that frames name
   */
  constructor(device, variants) {
    this.#device = device;
    this.#variants = new Map([...variants].map((variant) => [variant.hash, variant]));
  }

  /**
   * The buffer with a number of FrameWriter's.
   * @param {number} number
   */
  buffer(number) {
    const found = this.#buffers.get(number);
    if (!found) throw new Error(`no frame so far has buffer ${number}`);
    return found;
  }

  /**
   * Makes the pipelines that a frame needs, side by side: run() makes those that it misses one after
   * the other.
   * @param {Uint8Array} memory
   * @param {Omit<Target, "color" | "depth">} [target] formats of what its draws go into
   */
  async prepare(memory, target) {
    /** @type {Map<string, Promise<void>>} */
    const missing = new Map();
    for (const pass of readFrame(memory).lists.flatMap(({ passes }) => passes)) {
      const key = pass.kind < DRAW ? pass.kernel : drawKey(pass, target);
      if (this.#dispatches.has(key) || this.#draws.has(key) || missing.has(key)) continue;
      if (pass.kind < DRAW) {
        const { layouts, descriptor } = this.#dispatchDescriptor(pass);
        const made = this.#device.createComputePipelineAsync(descriptor);
        missing.set(key, made.then((pipeline) => void this.#dispatches.set(key, { pipeline, layouts })));
      } else if (target) {
        const { layouts, descriptor } = this.#drawDescriptor(pass, target);
        const made = this.#device.createRenderPipelineAsync(descriptor);
        missing.set(key, made.then((pipeline) => void this.#draws.set(key, { pipeline, layouts })));
      }
    }
    await Promise.all(missing.values());
  }

  /**
   * Runs a frame: makes its new buffers, and submits its lists one by one.
   * @param {Uint8Array} memory
   * @param {Target} [target] of its draws, without which a frame has none
   * @param {(list: number) => void} [before] called before each list is submitted: submit what is to
   *   run before it, as your draws of opaque objects
   */
  run(memory, target, before) {
    const frame = readFrame(memory);
    for (const number of frame.removed) {
      this.buffer(number).destroy();
      this.#buffers.delete(number);
    }
    for (const { buffer, size, usage, initial } of frame.added) {
      const made = this.#device.createBuffer({ size, usage: usageOf(usage) });
      this.#buffers.set(buffer, made);
      if (initial) this.#device.queue.writeBuffer(made, 0, frame.bytes, initial, size);
    }
    frame.lists.forEach((list, index) => {
      before?.(index);
      this.#submit(list, frame.bytes, target);
    });
  }

  /** Frees all buffers. */
  destroy() {
    for (const buffer of this.#buffers.values()) buffer.destroy();
    this.#buffers.clear();
  }

  /**
   * @param {List} list
   * @param {Uint8Array<ArrayBuffer>} bytes
   * @param {Target | undefined} target
   */
  #submit(list, bytes, target) {
    const { queue } = this.#device;
    for (const { buffer, offset, data, size } of list.uploads)
      queue.writeBuffer(this.buffer(buffer), offset, bytes, data, size);
    /** @type {GPUBuffer[]} */
    const once = [];
    const constants = list.constantsSize ? this.#once(once, list.constantsSize, GPUBufferUsage.UNIFORM) : null;
    if (constants) queue.writeBuffer(constants, 0, bytes, list.constants, list.constantsSize);
    const encoder = this.#device.createCommandEncoder();
    this.#dispatch(list.passes.filter(({ kind }) => kind < DRAW), encoder, constants, once);
    const draws = list.passes.filter(({ kind }) => kind >= DRAW);
    if (draws.length > 0) {
      if (!target) throw new Error("a frame with draws needs a target");
      this.#draw(draws, list.area, encoder, constants, target);
    }
    queue.submit([encoder.finish()]);
    for (const buffer of once) buffer.destroy();
  }

  /**
   * A buffer for the length of a list.
   * @param {GPUBuffer[]} once
   * @param {number} size
   * @param {number} usage
   */
  #once(once, size, usage) {
    const buffer = this.#device.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST });
    once.push(buffer);
    return buffer;
  }

  /**
   * @param {Pass[]} passes
   * @param {GPUCommandEncoder} encoder
   * @param {GPUBuffer | null} constants
   * @param {GPUBuffer[]} once
   */
  #dispatch(passes, encoder, constants, once) {
    /** @type {GPUComputePassEncoder | null} */
    let open = null;
    for (const pass of passes) {
      // A dispatch may not write the buffer that has its counts: they are copied out of it.
      let counts = null;
      if (pass.kind === DISPATCH_INDIRECT) {
        counts = this.#once(once, 12, GPUBufferUsage.INDIRECT);
        open?.end();
        open = null;
        encoder.copyBufferToBuffer(this.buffer(pass.counts), pass.countsOffset, counts, 0, 12);
      }
      open ??= encoder.beginComputePass();
      const { pipeline, layouts } = this.#dispatchPipeline(pass);
      open.setPipeline(pipeline);
      this.#bind(open, layouts, pass, constants);
      if (counts) open.dispatchWorkgroupsIndirect(counts, 0);
      else open.dispatchWorkgroups(pass.groups[0], pass.groups[1], pass.groups[2]);
    }
    open?.end();
  }

  /**
   * @param {Pass[]} passes
   * @param {List["area"]} area
   * @param {GPUCommandEncoder} encoder
   * @param {GPUBuffer | null} constants
   * @param {Target} target
   */
  #draw(passes, area, encoder, constants, target) {
    const open = encoder.beginRenderPass({
      colorAttachments: [{ view: target.color, loadOp: "load", storeOp: "store" }],
      depthStencilAttachment: target.depth && {
        view: target.depth,
        depthLoadOp: "load",
        depthStoreOp: "store",
      },
    });
    if (area.width > 0) open.setViewport(area.x, area.y, area.width, area.height, 0, 1);
    for (const pass of passes) {
      const { pipeline, layouts } = this.#drawPipeline(pass, target);
      open.setPipeline(pipeline);
      this.#bind(open, layouts, pass, constants);
      const input = this.#variant(pass.kernel).vertexInput;
      if (input) {
        slotsOf(input).forEach(({ offset }, slot) =>
          open.setVertexBuffer(slot, this.buffer(pass.vertices), pass.verticesOffset + offset, pass.verticesSize - offset),
        );
      }
      if (pass.kind !== DRAW) open.drawIndirect(this.buffer(pass.counts), pass.countsOffset);
      else if (pass.indices) {
        open.setIndexBuffer(this.buffer(pass.indices), "uint32");
        open.drawIndexed(pass.elements, pass.instances);
      } else open.draw(pass.elements, pass.instances);
    }
    open.end();
  }

  /**
   * @param {GPUBindingCommandsMixin} encoder
   * @param {GPUBindGroupLayout[]} layouts
   * @param {Pass} pass
   * @param {GPUBuffer | null} constants
   */
  #bind(encoder, layouts, pass, constants) {
    layouts.forEach((layout, set) => {
      const entries = pass.bindings
        .filter((bound) => bound.set === set)
        .map(({ entry, buffer, offset, size }) => {
          const bound = buffer ? this.buffer(buffer) : constants;
          if (!bound) throw new Error(`kernel ${pass.kernel} has a constant block that its list lacks`);
          return { binding: entry, resource: { buffer: bound, offset, size } };
        });
      encoder.setBindGroup(set, this.#device.createBindGroup({ layout, entries }));
    });
  }

  /** @param {string} hash */
  #variant(hash) {
    const found = this.#variants.get(hash);
    if (!found) throw new Error(`there is no WGSL of the kernel with hash ${hash}: it does not run on WebGPU, or was left out`);
    return found;
  }

  /** @param {Variant} variant */
  #module(variant) {
    let found = this.#modules.get(variant.hash);
    if (!found) {
      found = this.#device.createShaderModule({ label: variant.kernel, code: variant.code });
      this.#modules.set(variant.hash, found);
    }
    return found;
  }

  /** @param {Pass} pass */
  #dispatchPipeline(pass) {
    const found = this.#dispatches.get(pass.kernel);
    if (found) return found;
    const { layouts, descriptor } = this.#dispatchDescriptor(pass);
    const made = { pipeline: this.#device.createComputePipeline(descriptor), layouts };
    this.#dispatches.set(pass.kernel, made);
    return made;
  }

  /** @param {Pass} pass */
  #dispatchDescriptor(pass) {
    const variant = this.#variant(pass.kernel);
    const layouts = bindGroupLayouts(this.#device, [variant]);
    /** @type {GPUComputePipelineDescriptor} */
    const descriptor = {
      label: variant.kernel,
      layout: this.#device.createPipelineLayout({ bindGroupLayouts: layouts }),
      compute: { module: this.#module(variant), entryPoint: variant.kernel },
    };
    return { layouts, descriptor };
  }

  /** @param {Pass} pass @param {Target} target */
  #drawPipeline(pass, target) {
    const key = drawKey(pass, target);
    const found = this.#draws.get(key);
    if (found) return found;
    const { layouts, descriptor } = this.#drawDescriptor(pass, target);
    const made = { pipeline: this.#device.createRenderPipeline(descriptor), layouts };
    this.#draws.set(key, made);
    return made;
  }

  /** @param {Pass} pass @param {Omit<Target, "color" | "depth">} target */
  #drawDescriptor(pass, target) {
    const vertex = this.#variant(pass.kernel);
    const pixel = pass.pixel === NO_PIXEL ? null : this.#variant(pass.pixel);
    const layouts = bindGroupLayouts(this.#device, pixel ? [vertex, pixel] : [vertex]);
    const over = { srcFactor: "one", dstFactor: "one-minus-src-alpha" };
    const isBlended = (pass.state >> 7) % 2 === 1;
    /** @type {GPURenderPipelineDescriptor} */
    const descriptor = {
      label: vertex.kernel,
      layout: this.#device.createPipelineLayout({ bindGroupLayouts: layouts }),
      vertex: {
        module: this.#module(vertex),
        entryPoint: vertex.kernel,
        buffers: vertex.vertexInput && slotsOf(vertex.vertexInput).map(({ layout }) => layout),
      },
      primitive: { topology: TOPOLOGIES[pass.state % 8] },
      depthStencil: target.depthFormat && {
        format: target.depthFormat,
        depthCompare: COMPARES[(pass.state >> 3) % 8],
        depthWriteEnabled: (pass.state >> 6) % 2 === 1,
      },
      fragment: pixel
        ? {
            module: this.#module(pixel),
            entryPoint: pixel.kernel,
            targets: [
              {
                format: target.colorFormat,
                blend: isBlended ? /** @type {GPUBlendState} */ ({ color: over, alpha: over }) : undefined,
                writeMask: (pass.state >> 8) % 2 === 1 ? GPUColorWrite.ALL : 0,
              },
            ],
          }
        : undefined,
    };
    return { layouts, descriptor };
  }
}

/** @param {Pass} pass @param {Omit<Target, "color" | "depth">} [target] */
function drawKey(pass, target) {
  return [pass.kernel, pass.pixel, pass.state, target?.colorFormat, target?.depthFormat].join(" ");
}

/** @param {number} usage of BufferUsage */
function usageOf(usage) {
  return (
    GPUBufferUsage.STORAGE |
    GPUBufferUsage.COPY_DST |
    GPUBufferUsage.COPY_SRC |
    (usage & INDEX ? GPUBufferUsage.INDEX : 0) |
    (usage & INDIRECT ? GPUBufferUsage.INDIRECT : 0) |
    (usage & VERTEX ? GPUBufferUsage.VERTEX : 0)
  );
}

/**
 * The slots of vertex buffers: attributes may not reach beyond the stride, so that those of the next
 * element, which hair has, are in slots of their own.
 * @param {VertexInput} input
 */
function slotsOf({ step, stride, attributes }) {
  /** @type {Map<number, GPUVertexAttribute[]>} */
  const slots = new Map();
  for (const { location, type, components, offset } of attributes) {
    const first = Math.floor(offset / stride) * stride;
    const format = /** @type {GPUVertexFormat} */ (`${type}32${components > 1 ? `x${components}` : ""}`);
    const own = slots.get(first) ?? [];
    own.push({ shaderLocation: location, offset: offset - first, format });
    slots.set(first, own);
  }
  return [...slots].map(([offset, own]) => ({
    offset,
    layout: { arrayStride: stride, stepMode: step, attributes: own },
  }));
}

/**
 * The bind group layouts of a kernel, or of the two of a draw: one for each set, and empty ones where
 * they use none.
 * @param {GPUDevice} device
 * @param {Variant[]} variants
 */
export function bindGroupLayouts(device, variants) {
  const sets = Math.max(...variants.map((variant) => variant.sets));
  return Array.from({ length: sets }, (_, set) => {
    /** @type {Map<number, GPUBindGroupLayoutEntry>} */
    const entries = new Map();
    for (const { stage, bindings } of variants) {
      for (const { entry, kind, access } of bindings.filter((binding) => binding.set === set)) {
        const made = entries.get(entry) ?? { binding: entry, visibility: 0, ...resourceLayout(kind, access) };
        made.visibility |= visibilityOf(stage);
        entries.set(entry, made);
      }
    }
    return device.createBindGroupLayout({ entries: [...entries.values()] });
  });
}

/** @param {string} stage */
function visibilityOf(stage) {
  if (stage === "compute") return GPUShaderStage.COMPUTE;
  return stage === "vertex" ? GPUShaderStage.VERTEX : GPUShaderStage.FRAGMENT;
}

/**
 * @param {string} kind
 * @param {string} access
 * @returns {Partial<GPUBindGroupLayoutEntry>}
 */
function resourceLayout(kind, access) {
  switch (kind) {
    case "storageBuffer":
      return { buffer: { type: access === "read" ? "read-only-storage" : "storage" } };
    case "uniformBuffer":
      return { buffer: { type: "uniform" } };
    case "sampler":
      return { sampler: {} };
    case "sampledTexture":
      return { texture: { sampleType: "float" } };
    default:
      throw new Error(`WebGPU has no resource of kind ${kind}`);
  }
}
