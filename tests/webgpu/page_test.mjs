// The page in Chromium, with WebGPU in software: node page_test.mjs CHROMIUM SITE FOLDER
import assert from "node:assert";
import { createReadStream, existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { Browser } from "./browser.mjs";
import { checkPositions } from "./readback.mjs";

const [chromium, site, folder] = process.argv.slice(2);
const TYPES = { ".html": "text/html", ".css": "text/css", ".mjs": "text/javascript", ".json": "application/json", ".wasm": "application/wasm", ".png": "image/png" };
const SOFTWARE = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--disable-gpu-watchdog", "--window-size=640,240"];
// Without a GPU Chromium has no memory that WebGPU and what composes the page share, and loses the device
// for a canvas: the page draws into a texture of its own.
const NOT_SHOWN = `HTMLCanvasElement.prototype.getContext = () => ({
  configure({ device, format }) {
    this.texture = device.createTexture({ size: [64, 64], format, usage: GPUTextureUsage.RENDER_ATTACHMENT });
  },
  getCurrentTexture() {
    return this.texture;
  },
});`;

const server = createServer((request, response) => {
  const path = normalize(new URL(request.url, "http://localhost").pathname);
  const file = join(site, path === "/" ? "index.html" : path);
  if (!existsSync(file)) return response.writeHead(path === "/favicon.ico" ? 204 : 404).end();
  response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
  createReadStream(file).pipe(response);
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const address = `http://127.0.0.1:${server.address().port}/`;

/** Opens the page or a file of it, and closes it in the end. @param {string[]} options */
async function inBrowser(options, work, path = "?scene=parted&strands=200&follow=0") {
  const browser = new Browser(chromium, options);
  try {
    await browser.open(address + path, NOT_SHOWN);
    await work(browser);
  } finally {
    await browser.close();
  }
}

await inBrowser(SOFTWARE, async (browser) => {
  // Two frames are given to the device. SwiftShader takes minutes to compile the kernels that draw.
  await browser.until("Number(document.body.dataset.frames) >= 2");
  assert.equal(await browser.evaluate("document.getElementById('message').textContent"), "");
  assert.equal(await browser.evaluate("document.getElementById('scene').value"), "parted");

  // The parameters are the library's, and take values.
  assert((await browser.evaluate("document.querySelectorAll('#parameters label').length")) > 40);
  assert(await browser.evaluate(`(() => {
    const label = [...document.querySelectorAll("#parameters label")].find((one) => one.textContent.startsWith("wind.velocity"));
    const slider = label.querySelector("input");
    slider.value = slider.value === "1" ? "0" : "1";
    const before = label.querySelector("output").value;
    slider.dispatchEvent(new Event("input"));
    return document.getElementById("message").textContent === "" && label.querySelector("output").value !== before;
  })()`));
  // So are the presets; drags look around, pull hair and make wind.
  assert.equal(await browser.evaluate("document.querySelectorAll('#preset option').length"), 7);
  for (const drag of ["look", "pull", "wind"]) {
    await browser.evaluate(`document.getElementById("drag").value = "${drag}"`);
    await browser.drag([60, 60], [100, 80]);
  }
  assert.equal(await browser.evaluate("document.getElementById('message').textContent"), "");
  assert.deepEqual(browser.errors, []);
});

// The scene of wasm_test.mjs in the browser: its hair is where it is on Vulkan. It is not drawn.
const recorded = JSON.parse(readFileSync(join(folder, "page", "scene.json"), "utf8"));
const bytes = readFileSync(join(folder, "page", "scene.bin"));
const floatsAt = (offset, size) => new Float32Array(new Uint8Array(bytes.subarray(offset, offset + size)).buffer);
const { width, height } = recorded.picture;
const SHADOW_LIST = 2; // behind the one that simulates
const RUN = `(async () => {
  const { Core } = await import("./web_scene.mjs");
  const { Executor } = await import("./executor.mjs");
  const device = await (await navigator.gpu.requestAdapter()).requestDevice();
  const errors = [];
  device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
  const core = await Core.load(await (await fetch("pelage.wasm")).arrayBuffer());
  const executor = new Executor(device, await (await fetch("kernels.json")).json());
  const scene = core.head({ strands: 500, follow: 0, seed: 7 });
  scene.set("material", "fiberRadius", [0.001]);
  scene.set("simulation", "wind.velocity", [2, 0, 0]);
  const positions = async () => {
    const buffer = executor.buffer(scene.positionsBuffer(0));
    const mapped = device.createBuffer({ size: buffer.size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(buffer, 0, mapped, 0, buffer.size);
    device.queue.submit([encoder.finish()]);
    await mapped.mapAsync(GPUMapMode.READ);
    const all = new Uint8Array(mapped.getMappedRange());
    let text = "";
    for (let i = 0; i < all.length; i += 8192) text += String.fromCharCode(...all.subarray(i, i + 8192));
    return btoa(text);
  };
  let first = "";
  for (let i = 0; i < ${recorded.frames.length}; ++i) {
    try {
      executor.run(scene.frame(1 / 60, { eye: [0.2, 0.2, 0.8], target: [0, 0.15, 0], verticalFov: 0.6,
        width: ${width}, height: ${height} }), undefined, (list) => {
        if (list === ${SHADOW_LIST}) throw "simulated";
      });
    } catch (stop) {
      if (stop !== "simulated") throw stop;
    }
    await device.queue.onSubmittedWorkDone();
    if (i === 0) first = await positions();
  }
  return { errors, first, positions: await positions() };
})()`;
await inBrowser(
  SOFTWARE,
  async (browser) => {
    const { errors, first, positions } = await browser.evaluate(RUN);
    assert.deepEqual(errors, []);
    const [output] = recorded.outputs;
    const decoded = new Uint8Array(Buffer.from(positions, "base64")).buffer;
    assert.notEqual(first, positions, "hair moves");
    checkPositions(new Float32Array(decoded), floatsAt(output.expected, output.size));
    assert.deepEqual(browser.errors, []);
  },
  "page.css",
);

// Without WebGPU the page says so, and shows pictures.
await inBrowser(["--disable-gpu", "--disable-features=WebGPU", "--disable-blink-features=WebGPU"], async (browser) => {
  await browser.until("document.getElementById('message').textContent.includes('WebGPU')");
  console.log(await browser.evaluate("document.getElementById('message').textContent"));
  await browser.until("[...document.images].length === 2 && [...document.images].every((one) => one.naturalWidth > 300)");
});
server.close();
