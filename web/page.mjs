// The page: picks a scene, draws it while the page is seen, and has the library's parameters.
import { showParameters } from "./controls.mjs";
import { Orbit, takeDrags } from "./mouse.mjs";
import { SCENES } from "./scenes.mjs";
import { View } from "./view.mjs";
import { Core } from "./web_scene.mjs";

// In the address: ?scene=curly, ?strands=500 and ?follow=0 of a head.
const wanted = new URLSearchParams(location.search);

const LONGEST_STEP = 1 / 30; // of a frame [s]
const MOST_PIXELS = 1920; // along the canvas
const TIMED_FRAMES = 30;
const OPEN_FRAMES = 2; // that the device has not finished
const PICTURES = ["contact_sheet.png", "gallery_curly.png"]; // where there is no WebGPU

/** @param {string} id @returns {any} */
const element = (id) => document.getElementById(id);

/** @param {string} text */
function say(text) {
  element("message").textContent = text;
  element("message").hidden = text === "";
}

class NoWebGpu extends Error {}

async function makeDevice() {
  if (!navigator.gpu)
    throw new NoWebGpu("This browser has no WebGPU. Recent versions of Chrome, Edge, Safari and Firefox have it.");
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter) throw new NoWebGpu("WebGPU finds no graphics processor that it can use here.");
  return { device: await adapter.requestDevice(), isSoftware: adapter.info.isFallbackAdapter };
}

/** @param {string} path @returns {Promise<Response>} */
async function load(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(`cannot load ${path}: ${response.status}`);
  return response;
}

/** Frame times, as text of the last frames. */
class Times {
  /** @type {number[]} */
  #each = [];
  #host = 0;
  #last = performance.now();

  /** @param {number} host milliseconds that the frame took on the host */
  add(host) {
    const now = performance.now();
    this.#each.push(now - this.#last);
    this.#last = now;
    this.#host += host;
    if (this.#each.length < TIMED_FRAMES) return;
    const sorted = this.#each.sort((a, b) => a - b);
    const [median, longest] = [sorted[TIMED_FRAMES >> 1], sorted[TIMED_FRAMES - 1]];
    element("times").textContent =
      `${median.toFixed(1)} ms a frame (longest ${longest.toFixed(1)}), ${(this.#host / TIMED_FRAMES).toFixed(1)} ms on the host`;
    this.#each = [];
    this.#host = 0;
  }
}

/**
 * Runs until the device is lost.
 * @param {Core} core
 * @param {import("./executor.mjs").Variant[]} variants
 * @param {Orbit} orbit
 * @param {{scene: import("./web_scene.mjs").Scene, view: View, isReady: boolean}} shown set to what
 *   is drawn; whether its first frame was
 */
async function run(core, variants, orbit, shown) {
  const { device, isSoftware } = await makeDevice();
  const canvas = element("picture");
  const context = canvas.getContext("webgpu");
  const format = navigator.gpu.getPreferredCanvasFormat();
  context.configure({ device, format });
  device.addEventListener("uncapturederror", (/** @type {any} */ event) => {
    console.error(event.error.message);
    say(event.error.message);
  });

  let isLost = false;
  let isPaused = false;
  const clear = () => {
    shown.view?.destroy();
    shown.scene?.destroy();
  };
  const form = element("parameters");
  const pick = () => {
    clear();
    /** @param {string} name */
    const number = (name) => (wanted.has(name) ? Number(wanted.get(name)) : undefined);
    shown.scene = SCENES[element("scene").value](core, { strands: number("strands"), follow: number("follow") });
    shown.view = new View(device, variants, shown.scene);
    // A software driver compiles for minutes, and nothing side by side.
    shown.isReady = isSoftware;
    orbit.look(shown.scene.camera(canvas.clientWidth / canvas.clientHeight));
    showParameters(form, shown.scene, say);
    element("preset").selectedIndex = 0;
    say(isSoftware ? "" : "Compiling the kernels ...");
  };
  element("scene").onchange = pick;
  element("preset").onchange = () => {
    if (element("preset").value) shown.scene.takePreset(element("preset").value);
    showParameters(form, shown.scene, say);
  };
  element("pause").onclick = () => (isPaused = !isPaused);
  pick();

  const times = new Times();
  let before = 0;
  let count = 0;
  let open = 0;
  /** @type {View | null} */
  let prepared = null;
  const lost = device.lost.then(() => (isLost = true));
  /** @param {unknown} error */
  const fail = (error) => say(String(error));
  /** @param {number} now */
  const frame = (now) => {
    if (isLost) return;
    requestAnimationFrame(frame);
    const { view } = shown;
    if (open >= OPEN_FRAMES || (view === prepared && !shown.isReady)) return;
    const ratio = Math.min(devicePixelRatio, MOST_PIXELS / Math.max(canvas.clientWidth, 1));
    const width = Math.max(64, 64 * Math.floor((canvas.clientWidth * ratio) / 64));
    const height = Math.max(64, Math.floor(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const step = isPaused ? 0 : Math.min((now - before) / 1000, LONGEST_STEP);
    before = now;
    const begin = performance.now();
    try {
      view.resize(width, height);
      if (!shown.isReady) {
        prepared = view;
        view.prepare(step, orbit.camera).then(() => {
          if (view !== shown.view) return;
          shown.isReady = true;
          say("");
        }, fail);
        return;
      }
      view.draw(step, orbit.camera);
      view.show(context.getCurrentTexture().createView(), format);
    } catch (error) {
      fail(error);
      throw error;
    }
    ++open;
    device.queue.onSubmittedWorkDone().then(() => --open);
    times.add(performance.now() - begin);
    document.body.dataset.frames = String(++count);
  };
  requestAnimationFrame(frame);
  await lost;
  clear();
}

/** @param {Error} error */
function showPictures(error) {
  say(error.message);
  if (!(error instanceof NoWebGpu)) return;
  for (const id of ["picture", "parameters", "times"]) element(id).remove();
  for (const name of PICTURES) {
    const picture = document.createElement("img");
    picture.src = name;
    picture.alt = "Hair that pelage has drawn";
    document.body.append(picture);
  }
}

async function start() {
  for (const name of Object.keys(SCENES)) element("scene").append(new Option(name, name, false, name === wanted.get("scene")));
  const [wasm, variants] = await Promise.all([
    load("pelage.wasm").then((response) => response.arrayBuffer()),
    load("kernels.json").then((response) => response.json()),
  ]);
  const core = await Core.load(wasm);
  for (const { name, meaning } of core.presets) {
    const option = new Option(name, name);
    option.title = meaning;
    element("preset").append(option);
  }
  const orbit = new Orbit();
  /** @type {any} */
  const shown = {};
  takeDrags(
    element("picture"),
    orbit,
    () => (shown.isReady ? shown : null),
    () => element("drag").value,
    (error) => say(String(error)),
  );
  for (;;) {
    await run(core, variants, orbit, shown);
    say("The graphics processor was lost, and starts again.");
  }
}

start().catch(showPictures);
