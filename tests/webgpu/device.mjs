// A WebGPU device for tests, with the limits that every device has and no more.
import { create, globals } from "webgpu";

Object.assign(globalThis, globals);

// Once it is collected, promises of its devices are never kept.
const gpu = create(["backend=vulkan"]);

export async function testDevice() {
  globalThis.gpuOfTests = gpu;
  const adapter = await gpu.requestAdapter();
  if (!adapter) {
    if (process.env.PELAGE_REQUIRE_DEVICES === "1") throw new Error("Dawn finds no Vulkan driver");
    console.log("skipped: Dawn finds no Vulkan driver");
    process.exit(0);
  }
  console.log(`WebGPU on ${adapter.info.description}`);
  return adapter.requestDevice();
}
