// The page: picks a scene, draws it while the page is seen, and has the library's parameters.
import { SCENES } from "./scenes.mjs";
import { View, cameraAround } from "./view.mjs";
import { Core } from "./web_scene.mjs";

// In the address: ?scene=character, ?strands=500 of the head.
const wanted = new URLSearchParams(globalThis.location?.search);

const LONGEST_STEP = 1 / 30; // of a frame [s]
const MOST_PIXELS = 1920; // along the canvas
const TIMED_FRAMES = 20;
const OPEN_FRAMES = 2; // that the device has not finished

/** @param {string} id @returns {any} */
const element = (id) => document.getElementById(id);

/** @param {string} text */
function say(text) {
  element("message").textContent = text;
  element("message").hidden = text === "";
}

/** Looks at a point from all sides. */
class Orbit {
  #yaw = 0.4;
  #pitch = 0.1;
  #distance = 1;
  /** @type {[number, number, number]} */
  #target = [0, 0, 0];

  /** @param {HTMLElement} canvas */
  constructor(canvas) {
    canvas.addEventListener("pointermove", ({ buttons, movementX, movementY }) => {
      if (buttons === 0) return;
      this.#yaw -= 0.01 * movementX;
      this.#pitch = Math.min(Math.max(this.#pitch + 0.01 * movementY, -1.4), 1.4);
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.#distance = Math.min(Math.max(this.#distance * 1.001 ** event.deltaY, 0.2), 4);
      },
      { passive: false },
    );
  }

  /** @param {{target: [number, number, number], distance: number}} scene */
  look({ target, distance }) {
    this.#target = target;
    this.#distance = distance;
  }

  get camera() {
    return cameraAround(this.#target, this.#distance, this.#yaw, this.#pitch);
  }
}

/**
 * Controls for the parameters of a scene.
 * @param {import("./web_scene.mjs").Scene} scene
 */
function showParameters(scene) {
  const form = element("parameters");
  for (const group of form.querySelectorAll("details")) group.remove();
  /** @type {Map<string, HTMLElement>} */
  const groups = new Map();
  for (const parameter of scene.parameters) {
    const controls = controlsOf(parameter, (values) => {
      try {
        scene.set(parameter.section, parameter.path, values);
        say("");
      } catch (error) {
        say(String(error));
      }
    });
    if (controls.length === 0) continue;
    let group = groups.get(parameter.section);
    if (!group) {
      group = document.createElement("details");
      const title = document.createElement("summary");
      title.textContent = parameter.title;
      group.append(title);
      groups.set(parameter.section, group);
      form.append(group);
    }
    const label = document.createElement("label");
    label.title = parameter.meaning;
    label.append(`${parameter.path}${parameter.unit ? ` [${parameter.unit}]` : ""}`, ...controls);
    group.append(label);
  }
}

/**
 * @param {import("./web_scene.mjs").Parameter} parameter
 * @param {(values: number[]) => void} change
 * @returns {HTMLElement[]} none for curves
 */
export function controlsOf({ type, slider, choices, value }, change) {
  if (type === "curve") return [];
  if (type === "bool") {
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = value !== 0;
    box.addEventListener("change", () => change([box.checked ? 1 : 0]));
    return [box];
  }
  if (type === "choice") {
    const list = document.createElement("select");
    choices.forEach((choice, i) => list.append(new Option(choice, String(i), false, i === value)));
    list.addEventListener("change", () => change([list.selectedIndex]));
    return [list];
  }
  const values = Array.isArray(value) ? [...value] : [value];
  return values.map((one, i) => {
    const range = document.createElement("input");
    range.type = "range";
    const { position, valueAt } = scaleOf(slider, type === "count");
    range.min = "0";
    range.max = "1";
    range.step = "0.001";
    range.value = String(position(one));
    range.addEventListener("input", () => {
      values[i] = valueAt(Number(range.value));
      change(values);
    });
    return range;
  });
}

/**
 * @param {[number, number, number]} slider from, to, whether logarithmic
 * @param {boolean} isWhole
 */
export function scaleOf([low, high, isLog], isWhole) {
  const log = isLog && low > 0;
  const at = (/** @type {number} */ share) =>
    log ? low * (high / low) ** share : low + (high - low) * share;
  return {
    valueAt: (/** @type {number} */ share) => (isWhole ? Math.round(at(share)) : at(share)),
    position: (/** @type {number} */ value) =>
      log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low),
  };
}

async function makeDevice() {
  if (!navigator.gpu) throw new Error("This browser has no WebGPU. Recent versions of Chrome, Edge, Safari and Firefox have it.");
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter) throw new Error("WebGPU finds no graphics processor that it can use here.");
  return adapter.requestDevice();
}

/** @param {string} path @returns {Promise<Response>} */
async function load(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(`cannot load ${path}: ${response.status}`);
  return response;
}

/**
 * Runs until the device is lost.
 * @param {Core} core
 * @param {import("./executor.mjs").Variant[]} variants
 * @param {Orbit} orbit
 */
async function run(core, variants, orbit) {
  const device = await makeDevice();
  const canvas = element("picture");
  const context = canvas.getContext("webgpu");
  const format = navigator.gpu.getPreferredCanvasFormat();
  context.configure({ device, format });
  device.addEventListener("uncapturederror", (/** @type {any} */ event) => {
    console.error(event.error.message);
    say(event.error.message);
  });

  const picker = element("scene");
  /** @type {import("./web_scene.mjs").Scene} */
  let scene;
  /** @type {View} */
  let view;
  let isLost = false;
  let isPaused = false;
  const clear = () => {
    view?.destroy();
    scene?.destroy();
  };
  const pick = () => {
    clear();
    const picked = SCENES[picker.value];
    scene = picked.make(core, wanted.has("strands") ? Number(wanted.get("strands")) : undefined);
    orbit.look(picked);
    view = new View(device, variants, scene);
    showParameters(scene);
    say("");
  };
  picker.onchange = pick;
  element("pause").onclick = () => (isPaused = !isPaused);
  pick();

  let before = 0;
  let work = 0;
  let count = 0;
  let open = 0;
  let since = performance.now();
  const lost = device.lost.then(() => (isLost = true));
  /** @param {number} now */
  const frame = (now) => {
    if (isLost) return;
    requestAnimationFrame(frame);
    if (open >= OPEN_FRAMES) return;
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
      view.draw(step, orbit.camera);
      view.show(context.getCurrentTexture().createView(), format);
    } catch (error) {
      say(String(error));
      throw error;
    }
    ++open;
    device.queue.onSubmittedWorkDone().then(() => --open);
    work += performance.now() - begin;
    document.body.dataset.frames = String(++count);
    if (count % TIMED_FRAMES === 0) {
      const each = (performance.now() - since) / TIMED_FRAMES;
      element("times").textContent = `${each.toFixed(1)} ms a frame, ${(work / TIMED_FRAMES).toFixed(1)} ms of it on the host`;
      since = performance.now();
      work = 0;
    }
  };
  requestAnimationFrame(frame);
  await lost;
  clear();
}

async function start() {
  for (const name of Object.keys(SCENES)) element("scene").append(new Option(name, name, false, name === wanted.get("scene")));
  const [wasm, variants] = await Promise.all([
    load("pelage.wasm").then((response) => response.arrayBuffer()),
    load("kernels.json").then((response) => response.json()),
  ]);
  const core = await Core.load(wasm);
  const orbit = new Orbit(element("picture"));
  for (;;) {
    await run(core, variants, orbit);
    say("The graphics processor was lost, and starts again.");
  }
}

start().catch((error) => say(error.message));
