// Hair on a canvas of a page: import { addHair } from this module, and call it for the canvas.
// Serve the page over https, or from localhost.
import { View, load } from "@pelage/webgpu";

/**
 * @param {HTMLCanvasElement} canvas
 * @param {{groom?: string, wind?: number[]}} [options]
 * @returns {Promise<{scene: import("@pelage/webgpu").Scene, stop: () => void}>}
 */
export async function addHair(canvas, { groom = "curly", wind = [0, 0, 0] } = {}) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) throw new Error("this browser has no WebGPU");
  const device = await adapter.requestDevice();
  const { core, variants } = await load();

  // A head with hair of the gallery; core.hair(bytes) takes a .tfx file of your own.
  const scene = core.head({ groom });
  scene.set("simulation", "wind.velocity", wind);
  const view = new View(device, variants, scene);

  const context = /** @type {GPUCanvasContext} */ (canvas.getContext("webgpu"));
  const format = navigator.gpu.getPreferredCanvasFormat();
  context.configure({ device, format });
  // The width of a picture is a multiple of 64.
  canvas.width = 64 * Math.ceil(canvas.clientWidth / 64);
  canvas.height = canvas.clientHeight;
  view.resize(canvas.width, canvas.height);
  const camera = scene.camera(canvas.width / canvas.height);
  await view.prepare(1 / 60, camera);

  let isRunning = true;
  let before = performance.now();
  /** @param {number} now */
  const frame = async (now) => {
    if (!isRunning) return;
    // Longer steps than this are those of a page that was hidden.
    const seconds = Math.min(Math.max(now - before, 0) / 1000, 1 / 30);
    before = now;
    view.draw(seconds, camera);
    view.show(context.getCurrentTexture().createView(), format);
    await device.queue.onSubmittedWorkDone();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);

  return {
    scene,
    stop: () => {
      isRunning = false;
      view.destroy();
      scene.destroy();
      device.destroy();
    },
  };
}
