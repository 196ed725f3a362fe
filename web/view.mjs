// What a page draws: a scene into a picture, and the picture on a canvas; hair that is pulled.
import { Executor } from "./executor.mjs";
import { COUNTER_BYTES, DEPTH_LIST } from "./web_scene.mjs";

/** @type {{colorFormat: GPUTextureFormat, depthFormat: GPUTextureFormat}} */
const FORMATS = { colorFormat: "rgba16float", depthFormat: "depth32float" };

// A triangle over all of the canvas, with the picture over a background; colors are linear up to here.
const SHOW = `
const background = vec3(0.05, 0.055, 0.065);
@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
  return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment fn show(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let drawn = textureLoad(picture, vec2<i32>(at.xy), 0);
  let linear = clamp(drawn.rgb + (1.0 - drawn.a) * background, vec3(0.0), vec3(1.0));
  let low = linear * 12.92;
  let high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  return vec4(select(high, low, linear <= vec3(0.0031308)), 1.0);
}`;

/** @typedef {import("./web_scene.mjs").Camera} Camera */

/** A scene on a device. */
export class View {
  #device;
  #scene;
  #executor;
  /** @type {{width: number, height: number, color: GPUTexture, depth: GPUTexture} | null} */
  #picture = null;
  #isDestroyed = false;
  #isCounting = false;
  /** @type {Map<GPUTextureFormat, GPURenderPipeline>} */
  #shows = new Map();

  /**
   * @param {GPUDevice} device
   * @param {Iterable<import("./executor.mjs").Variant>} variants
   * @param {import("./web_scene.mjs").Scene} scene one that has no frames yet
   */
  constructor(device, variants, scene) {
    this.#device = device;
    this.#scene = scene;
    this.#executor = new Executor(device, variants);
  }

  /**
   * Sets the size of the next pictures.
   * @param {number} width a multiple of 64
   * @param {number} height
   */
  resize(width, height) {
    if (width === this.#picture?.width && height === this.#picture.height) return;
    if (width % 64 !== 0) throw new Error(`the width of a picture is ${width}, which is no multiple of 64`);
    this.#picture?.color.destroy();
    this.#picture?.depth.destroy();
    const { RENDER_ATTACHMENT, TEXTURE_BINDING, COPY_SRC } = GPUTextureUsage;
    const size = [width, height];
    const color = this.#device.createTexture({ size, format: FORMATS.colorFormat, usage: RENDER_ATTACHMENT | TEXTURE_BINDING | COPY_SRC });
    const depth = this.#device.createTexture({ size, format: FORMATS.depthFormat, usage: RENDER_ATTACHMENT | COPY_SRC });
    this.#picture = { width, height, color, depth };
  }

  get #sized() {
    if (!this.#picture) throw new Error("a view has no size: call resize()");
    return this.#picture;
  }

  /** The last picture: linear colors, multiplied by their alpha. */
  get color() {
    return this.#sized.color;
  }

  get executor() {
    return this.#executor;
  }

  /**
   * Simulates and draws the next frame into the picture.
   * @param {number} seconds
   * @param {Omit<Camera, "width" | "height">} from
   */
  draw(seconds, from) {
    const { width, height } = this.#sized;
    this.#run(this.#scene.frame(seconds, { ...from, width, height }));
  }

  /**
   * Does the same for the first frame, and makes its pipelines side by side. Wait for it before
   * the next call.
   * @param {number} seconds
   * @param {Omit<Camera, "width" | "height">} from
   */
  async prepare(seconds, from) {
    const { width, height } = this.#sized;
    const frame = this.#scene.frame(seconds, { ...from, width, height }).slice();
    await this.#executor.prepare(frame, FORMATS);
    if (!this.#isDestroyed) this.#run(frame);
  }

  /** @param {Uint8Array} frame */
  #run(frame) {
    const { color, depth } = this.#sized;
    const target = { ...FORMATS, color: color.createView(), depth: depth.createView() };
    this.#clear(target);
    this.#executor.run(frame, target, (list) => {
      if (list === DEPTH_LIST) this.#copyDepth();
    });
    if (!this.#isCounting) void this.#count();
  }

  // Gives the scene room for the fragments of this frame, in one of the next ones.
  async #count() {
    const picture = this.#sized;
    const counters = this.#device.createBuffer({
      size: COUNTER_BYTES,
      usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST,
    });
    const encoder = this.#device.createCommandEncoder();
    encoder.copyBufferToBuffer(this.#executor.buffer(this.#scene.countersBuffer), 0, counters, 0, COUNTER_BYTES);
    this.#device.queue.submit([encoder.finish()]);
    this.#isCounting = true;
    try {
      await counters.mapAsync(GPUMapMode.READ);
    } catch {
      return; // the device is lost
    }
    this.#isCounting = false;
    if (!this.#isDestroyed && picture === this.#picture)
      this.#scene.takeCounters(new Uint8Array(counters.getMappedRange()));
    counters.destroy();
  }

  /**
   * Shows the picture.
   * @param {GPUTextureView} view
   * @param {GPUTextureFormat} format
   */
  show(view, format) {
    let pipeline = this.#shows.get(format);
    if (!pipeline) {
      const module = this.#device.createShaderModule({ code: SHOW });
      pipeline = this.#device.createRenderPipeline({
        layout: "auto",
        vertex: { module, entryPoint: "corner" },
        fragment: { module, entryPoint: "show", targets: [{ format }] },
      });
      this.#shows.set(format, pipeline);
    }
    const encoder = this.#device.createCommandEncoder();
    const pass = encoder.beginRenderPass({
      colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }],
    });
    pass.setPipeline(pipeline);
    const entries = [{ binding: 0, resource: this.color.createView() }];
    pass.setBindGroup(0, this.#device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
    pass.draw(3);
    pass.end();
    this.#device.queue.submit([encoder.finish()]);
  }

  destroy() {
    this.#isDestroyed = true;
    this.#executor.destroy();
    this.#picture?.color.destroy();
    this.#picture?.depth.destroy();
  }

  /**
   * Takes the lock of hair at a pixel of the picture: a promise of whether hair is there.
   * @param {number} x pixels from the left
   * @param {number} y pixels from the top
   */
  async pull(x, y) {
    const hairs = Array.from({ length: this.#scene.hairs }, (_, i) => i);
    const size = hairs.reduce((sum, hair) => sum + this.#scene.guideBytes(hair), 0);
    const guides = this.#device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = this.#device.createCommandEncoder();
    let at = 0;
    for (const hair of hairs) {
      const bytes = this.#scene.guideBytes(hair);
      encoder.copyBufferToBuffer(this.#executor.buffer(this.#scene.positionsBuffer(hair)), 0, guides, at, bytes);
      at += bytes;
    }
    this.#device.queue.submit([encoder.finish()]);
    await guides.mapAsync(GPUMapMode.READ);
    const isHeld = !this.#isDestroyed && this.#scene.pull(x, y, new Uint8Array(guides.getMappedRange()));
    guides.destroy();
    return isHeld;
  }

  /** @param {{color: GPUTextureView, depth: GPUTextureView}} target */
  #clear({ color, depth }) {
    const encoder = this.#device.createCommandEncoder();
    encoder
      .beginRenderPass({
        colorAttachments: [{ view: color, loadOp: "clear", storeOp: "store" }],
        depthStencilAttachment: { view: depth, depthLoadOp: "clear", depthClearValue: 1, depthStoreOp: "store" },
      })
      .end();
    this.#device.queue.submit([encoder.finish()]);
  }

  // Gives the depth of the body to the hair.
  #copyDepth() {
    const { width, height, depth } = this.#sized;
    const encoder = this.#device.createCommandEncoder();
    encoder.copyTextureToBuffer(
      { texture: depth },
      { buffer: this.#executor.buffer(this.#scene.depthBuffer), bytesPerRow: 4 * width },
      [width, height],
    );
    this.#device.queue.submit([encoder.finish()]);
  }
}
