// Looking around keeps what is looked at, and vectors across the picture are in its plane:
// node mouse_test.mjs
import assert from "node:assert";
import { Orbit } from "./mouse.mjs";

const near = (a, b) => a.every((value, i) => Math.abs(value - b[i]) < 1e-9);
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);

const orbit = new Orbit();
const start = { eye: [0.4, 0.5, 0.9], target: [0.1, 0.2, -0.1], verticalFov: 0.5 };
orbit.look(start);
assert(near(orbit.camera.eye, start.eye) && near(orbit.camera.target, start.target));
assert.equal(orbit.camera.verticalFov, 0.5);

orbit.rotate(0.7, -0.2);
orbit.zoom(0.5);
const { eye, target } = orbit.camera;
const back = eye.map((value, i) => value - target[i]);
const distance = Math.hypot(...start.eye.map((value, i) => value - start.target[i]));
assert(Math.abs(Math.hypot(...back) - 0.5 * distance) < 1e-9 && near(target, start.target));
const [right, up] = [orbit.across(1, 0), orbit.across(0, 1)];
for (const [a, b, product] of [[right, back, 0], [up, back, 0], [right, up, 0], [right, right, 1], [up, up, 1]])
  assert(Math.abs(dot(a, b) - product) < 1e-9);
assert(right[1] === 0 && up[1] > 0);
// Dragged to the right, the camera orbits to the left.
const first = orbit.camera.eye;
orbit.rotate(0.1, 0);
assert(dot(orbit.camera.eye.map((value, i) => value - first[i]), right) < 0);
