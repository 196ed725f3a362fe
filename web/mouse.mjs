// What the mouse, or a finger, does to the scene: looks around, pulls hair, makes wind.

/** @typedef {[number, number, number]} Vector */
/** @typedef {Omit<import("./web_scene.mjs").Camera, "width" | "height">} Viewpoint */
/** @typedef {"look" | "pull" | "wind"} Drag */

const MOST_WIND = 8; // of a drag over half the picture's height [m/s]

/** Looks at a point from all sides. */
export class Orbit {
  #yaw = 0;
  #pitch = 0;
  #distance = 1;
  #fov = 0.6;
  /** @type {Vector} */
  #target = [0, 0, 0];

  /** @param {Viewpoint} viewpoint to begin with */
  look({ eye, target, verticalFov }) {
    const [x, y, z] = eye.map((value, i) => value - target[i]);
    this.#distance = Math.hypot(x, y, z);
    this.#yaw = Math.atan2(x, z);
    this.#pitch = Math.asin(y / this.#distance);
    this.#target = target;
    this.#fov = verticalFov;
  }

  /** @param {number} right [rad] @param {number} down [rad] */
  rotate(right, down) {
    this.#yaw -= right;
    this.#pitch = Math.min(Math.max(this.#pitch + down, -1.4), 1.4);
  }

  /** @param {number} factor of the distance */
  zoom(factor) {
    this.#distance = Math.min(Math.max(this.#distance * factor, 0.2), 6);
  }

  /** @returns {Viewpoint} */
  get camera() {
    const flat = this.#distance * Math.cos(this.#pitch);
    const [x, y, z] = this.#target;
    const eye = /** @type {Vector} */ ([
      x + flat * Math.sin(this.#yaw),
      y + this.#distance * Math.sin(this.#pitch),
      z + flat * Math.cos(this.#yaw),
    ]);
    return { eye, target: this.#target, verticalFov: this.#fov };
  }

  /**
   * A vector in the plane of the picture.
   * @param {number} right
   * @param {number} up
   * @returns {Vector}
   */
  across(right, up) {
    const [sine, cosine] = [Math.sin(this.#yaw), Math.cos(this.#yaw)];
    const lean = Math.sin(this.#pitch);
    return [right * cosine - up * sine * lean, up * Math.cos(this.#pitch), -right * sine - up * cosine * lean];
  }
}

/**
 * Takes the drags on a canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {Orbit} orbit
 * @param {() => {scene: import("./web_scene.mjs").Scene, view: import("./view.mjs").View} | null} shown
 * @param {() => Drag} chosen of drags without Alt, which pull
 * @param {(error: unknown) => void} fail
 */
export function takeDrags(canvas, orbit, shown, chosen, fail) {
  /** @type {Drag | null} */
  let drag = null;
  /** @type {[number, number]} */
  let pressed = [0, 0];
  /** @param {PointerEvent} event @returns {[number, number]} */
  const pixel = ({ offsetX, offsetY }) => [
    (offsetX * canvas.width) / canvas.clientWidth,
    (offsetY * canvas.height) / canvas.clientHeight,
  ];
  canvas.addEventListener("pointerdown", (event) => {
    const now = shown();
    if (!now) return;
    const { scene, view } = now;
    canvas.setPointerCapture(event.pointerId);
    drag = event.altKey ? "pull" : chosen();
    pressed = [event.offsetX, event.offsetY];
    if (drag === "wind") scene.set("simulation", "wind.velocity", [0, 0, 0]);
    if (drag !== "pull") return;
    view.pull(...pixel(event)).then((isHeld) => {
      if (isHeld && drag !== "pull") scene.release();
    }, fail);
  });
  canvas.addEventListener("pointermove", (event) => {
    const scene = shown()?.scene;
    if (drag === "look") orbit.rotate(0.01 * event.movementX, 0.01 * event.movementY);
    if (drag === "pull") scene?.dragTo(...pixel(event));
    if (drag !== "wind") return;
    const [right, down] = [event.offsetX - pressed[0], event.offsetY - pressed[1]];
    const factor = (2 * MOST_WIND) / canvas.clientHeight;
    scene?.set("simulation", "wind.velocity", orbit.across(factor * right, -factor * down));
  });
  const end = () => {
    if (drag === "pull") shown()?.scene.release();
    drag = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      orbit.zoom(1.001 ** event.deltaY);
    },
    { passive: false },
  );
}
