// The WGSL of a build as its reflection describes it.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";

/**
 * @param {string} path of reflection.json
 * @returns {{variants: (import("./executor.mjs").Variant & {key: string})[], missing: {kernel: string, why: string}[]}}
 */
export function readKernels(path) {
  const reflection = JSON.parse(readFileSync(path, "utf8"));
  const layouts = new Map(reflection.layouts.map((layout) => [layout.name, layout]));
  const variants = [];
  const missing = [];
  for (const kernel of reflection.kernels) {
    for (const variant of kernel.variants) {
      if (variant.noWebgpu) {
        missing.push({ kernel: kernel.name, why: variant.noWebgpu });
        continue;
      }
      variants.push({
        kernel: kernel.name,
        stage: kernel.stage,
        key: variant.keys[0],
        hash: variant.hash,
        sets: kernel.layouts.length,
        vertexInput: kernel.vertexInput,
        bindings: variant.bindings.map(({ set, entry, name, access }) => ({
          set,
          entry,
          name,
          access,
          kind: layouts.get(kernel.layouts[set]).entries[entry].kind,
        })),
        code: readFileSync(join(dirname(path), "wgsl", `${kernel.name}_${variant.hash}.wgsl`), "utf8"),
      });
    }
  }
  return { variants, missing };
}
