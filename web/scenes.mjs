// What the page has to show, and from where.

/**
 * A scene, which may take another number of strands, and the camera of its first picture.
 * @typedef {{make: (core: import("./web_scene.mjs").Core, strands?: number) => import("./web_scene.mjs").Scene,
 *   target: [number, number, number], distance: number}} Shown
 */

/** @type {Record<string, Shown>} */
export const SCENES = {
  head: { make: (core, strands = 2000) => core.head(strands), target: [0, 0.14, 0], distance: 0.8 },
  character: { make: (core) => core.character(), target: [0, 0.05, 0], distance: 1.2 },
};
