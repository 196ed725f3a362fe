// What a page draws: a body, hair over it by tiles, and the picture on a canvas.
import { Executor } from "./executor.mjs";
import { DEPTH_LIST } from "./web_scene.mjs";

const COLOR = "rgba16float";
const DEPTH = "depth32float";
const BODY_STRIDE = 36;
const BACKGROUND = { r: 0.02, g: 0.022, b: 0.027, a: 1 };

const BODY = `
struct Camera { clip: mat4x4<f32> }
@group(0) @binding(0) var<uniform> camera: Camera;

struct Corner {
  @builtin(position) clip: vec4<f32>,
  @location(0) normal: vec3<f32>,
  @location(1) color: vec3<f32>,
}

@vertex fn corner(@location(0) at: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) color: vec3<f32>) -> Corner {
  return Corner(camera.clip * vec4(at, 1.0), normal, color);
}

@fragment fn shade(in: Corner) -> @location(0) vec4<f32> {
  let facing = max(dot(normalize(in.normal), normalize(vec3(0.35, 0.75, 0.55))), 0.0);
  return vec4(in.color * (0.2 + 0.8 * facing), 1.0);
}`;

// A triangle over all of the canvas; colors are linear up to here.
const SHOW = `
@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
  return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment fn show(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let linear = clamp(textureLoad(picture, vec2<i32>(at.xy), 0).rgb, vec3(0.0), vec3(1.0));
  let low = linear * 12.92;
  let high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  return vec4(select(high, low, linear <= vec3(0.0031308)), 1.0);
}`;

/** @typedef {import("./web_scene.mjs").Camera} Camera */

/**
 * Columns of the matrix from the world to clip space.
 * @param {Camera} camera
 */
export function clipMatrix({ eye, target, verticalFov, width, height }) {
  const [near, far] = [0.05, 20];
  const minus = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a.map((value, i) => value - b[i]);
  const dot = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
  const unit = (/** @type {number[]} */ a) => a.map((value) => value / Math.hypot(...a));
  const cross = (/** @type {number[]} */ a, /** @type {number[]} */ b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ];
  const back = unit(minus(eye, target));
  const right = unit(cross([0, 1, 0], back));
  const up = cross(back, right);
  const scale = 1 / Math.tan(verticalFov / 2);
  const depth = far / (near - far);
  /** @param {number[]} axis @param {number} factor */
  const row = (axis, factor) => [...axis.map((value) => factor * value), -factor * dot(axis, eye)];
  const rows = [row(right, (scale * height) / width), row(up, scale), row(back, depth), row(back, -1)];
  rows[2][3] += near * depth;
  return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((values) => values[column])));
}

/**
 * A camera that looks at a point from a side.
 * @param {[number, number, number]} target
 * @param {number} distance [m]
 * @param {number} yaw [rad]
 * @param {number} pitch [rad]
 * @returns {Omit<Camera, "width" | "height">}
 */
export function cameraAround([x, y, z], distance, yaw, pitch) {
  const flat = distance * Math.cos(pitch);
  return {
    eye: [x + flat * Math.sin(yaw), y + distance * Math.sin(pitch), z + flat * Math.cos(yaw)],
    target: [x, y, z],
    verticalFov: 0.6,
  };
}

/** A scene on a device. */
export class View {
  #device;
  #scene;
  #executor;
  #matrix;
  #body;
  /** @type {{width: number, height: number, color: GPUTexture, depth: GPUTexture} | null} */
  #picture = null;
  /** @type {{vertices: GPUBuffer, indices: GPUBuffer, count: number} | null} */
  #mesh = null;
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
    this.#matrix = device.createBuffer({ size: 64, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    const module = device.createShaderModule({ code: BODY });
    /** @type {GPUVertexBufferLayout} */
    const layout = {
      arrayStride: BODY_STRIDE,
      attributes: [0, 12, 24].map((offset, shaderLocation) => ({ offset, shaderLocation, format: "float32x3" })),
    };
    this.#body = device.createRenderPipeline({
      layout: "auto",
      vertex: { module, entryPoint: "corner", buffers: [layout] },
      fragment: { module, entryPoint: "shade", targets: [{ format: COLOR }] },
      depthStencil: { format: DEPTH, depthCompare: "less", depthWriteEnabled: true },
    });
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
    const color = this.#device.createTexture({ size, format: COLOR, usage: RENDER_ATTACHMENT | TEXTURE_BINDING | COPY_SRC });
    const depth = this.#device.createTexture({ size, format: DEPTH, usage: RENDER_ATTACHMENT | COPY_SRC });
    this.#picture = { width, height, color, depth };
  }

  get #sized() {
    if (!this.#picture) throw new Error("a view has no size: call resize()");
    return this.#picture;
  }

  /** The last picture, with linear colors. */
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
    const { width, height, color, depth } = this.#sized;
    const camera = { ...from, width, height };
    const frame = this.#scene.frame(seconds, camera);
    const target = {
      color: color.createView(),
      colorFormat: /** @type {GPUTextureFormat} */ (COLOR),
      depth: depth.createView(),
      depthFormat: /** @type {GPUTextureFormat} */ (DEPTH),
    };
    this.#executor.run(frame, target, (list) => {
      if (list === DEPTH_LIST) this.#drawBody(camera, target);
    });
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
    this.#executor.destroy();
    for (const resource of [this.#picture?.color, this.#picture?.depth, this.#matrix, this.#mesh?.vertices, this.#mesh?.indices])
      resource?.destroy();
  }

  // Clears the picture, draws the body, and gives its depth to the hair.
  /** @param {Camera} camera @param {{color: GPUTextureView, depth: GPUTextureView}} target */
  #drawBody(camera, { color, depth }) {
    const { queue } = this.#device;
    const mesh = this.#bodyMesh();
    queue.writeBuffer(this.#matrix, 0, clipMatrix(camera));
    const encoder = this.#device.createCommandEncoder();
    const pass = encoder.beginRenderPass({
      colorAttachments: [{ view: color, loadOp: "clear", clearValue: BACKGROUND, storeOp: "store" }],
      depthStencilAttachment: { view: depth, depthLoadOp: "clear", depthClearValue: 1, depthStoreOp: "store" },
    });
    if (mesh) {
      const entries = [{ binding: 0, resource: { buffer: this.#matrix } }];
      pass.setPipeline(this.#body);
      pass.setBindGroup(0, this.#device.createBindGroup({ layout: this.#body.getBindGroupLayout(0), entries }));
      pass.setVertexBuffer(0, mesh.vertices);
      pass.setIndexBuffer(mesh.indices, "uint32");
      pass.drawIndexed(mesh.count);
    }
    pass.end();
    encoder.copyTextureToBuffer(
      { texture: this.#sized.depth },
      { buffer: this.#executor.buffer(this.#scene.depthBuffer), bytesPerRow: 4 * camera.width },
      [camera.width, camera.height],
    );
    queue.submit([encoder.finish()]);
  }

  #bodyMesh() {
    const vertices = this.#scene.body;
    if (vertices.length === 0) return null;
    if (!this.#mesh) {
      const indices = this.#scene.bodyIndices;
      const make = (/** @type {number} */ size, /** @type {number} */ usage) =>
        this.#device.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST });
      this.#mesh = {
        vertices: make(vertices.byteLength, GPUBufferUsage.VERTEX),
        indices: make(indices.byteLength, GPUBufferUsage.INDEX),
        count: indices.length,
      };
      this.#device.queue.writeBuffer(this.#mesh.indices, 0, indices);
    }
    this.#device.queue.writeBuffer(this.#mesh.vertices, 0, vertices);
    return this.#mesh;
  }
}
