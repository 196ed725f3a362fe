// What the page has to show.
import { GROOMS } from "./web_scene.mjs";

/** @typedef {import("./web_scene.mjs").Core} Core */
/** @typedef {import("./web_scene.mjs").Scene} Scene */

/** @type {Record<string, (core: Core, numbers?: {strands?: number, follow?: number}) => Scene>} */
export const SCENES = { character: (core) => core.character() };
for (const groom of GROOMS) SCENES[groom] = (core, numbers) => core.head({ groom, ...numbers });
