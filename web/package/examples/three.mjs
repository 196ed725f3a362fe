// Hair in a scene of three.js, on the renderer's device: each hides what is behind it.
import { DEPTH_LIST, Executor, load } from "@pelage/webgpu";
import * as THREE from "three/webgpu";
import { texture } from "three/tsl";

// Of Scene.frame(): a camera of three.js has the same, so that depths are the same.
const [NEAR, FAR] = [0.05, 20];

const COPY_DEPTH = `
@group(0) @binding(0) var depth: texture_depth_2d;
@group(0) @binding(1) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(8, 8) fn copy(@builtin(global_invocation_id) at: vec3<u32>) {
  let size = textureDimensions(depth);
  if (all(at.xy < size)) { depths[at.y * size.x + at.x] = textureLoad(depth, at.xy, 0); }
}`;

/**
 * @param {THREE.WebGPURenderer} renderer after renderer.init()
 * @param {THREE.Scene} world
 * @param {number} width of the pictures
 * @param {number} height
 * @param {Parameters<import("@pelage/webgpu").Core["head"]>[0]} [def] of the head
 */
export async function addHair(renderer, world, width, height, def) {
  const { device } = renderer.backend;
  const { core, variants } = await load();
  const hair = core.head(def);
  const executor = new Executor(device, variants);
  const start = hair.camera(width / height);
  const camera = new THREE.PerspectiveCamera((180 / Math.PI) * start.verticalFov, width / height, NEAR, FAR);
  camera.position.set(...start.eye);
  camera.lookAt(...start.target);

  // three.js draws into this, then pelage, then three.js shows it.
  const depthTexture = new THREE.DepthTexture(width, height, THREE.FloatType);
  const picture = new THREE.RenderTarget(width, height, { type: THREE.HalfFloatType, depthTexture });
  const material = new THREE.NodeMaterial();
  material.fragmentNode = texture(picture.texture);
  const quad = new THREE.QuadMesh(material);

  const module = device.createShaderModule({ code: COPY_DEPTH });
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module, entryPoint: "copy" } });
  const direction = new THREE.Vector3();

  /** @param {number} seconds since the last frame */
  const draw = (seconds) => {
    renderer.setRenderTarget(picture);
    renderer.render(world, camera);

    const depth = renderer.backend.get(depthTexture).texture.createView();
    const color = renderer.backend.get(picture.texture).texture.createView();
    const target = camera.getWorldDirection(direction).add(camera.position).toArray();
    const verticalFov = (camera.fov * Math.PI) / 180;
    const frame = hair.frame(seconds, { eye: camera.position.toArray(), target, verticalFov, width, height });
    executor.run(frame, { color, colorFormat: "rgba16float", depth, depthFormat: "depth32float" }, (list) => {
      if (list !== DEPTH_LIST) return;
      const encoder = device.createCommandEncoder();
      const pass = encoder.beginComputePass();
      const buffer = executor.buffer(hair.depthBuffer);
      const entries = [depth, { buffer }].map((resource, binding) => ({ binding, resource }));
      pass.setPipeline(pipeline);
      pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
      pass.dispatchWorkgroups(Math.ceil(width / 8), Math.ceil(height / 8));
      pass.end();
      device.queue.submit([encoder.finish()]);
    });

    renderer.setRenderTarget(null);
    quad.render(renderer);
  };
  return { hair, camera, picture, draw };
}
