// The WGSL of a build as its reflection describes it.
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";

/**
 * @typedef {{set: number, entry: number, name: string, access: string, kind: string}} Binding
 * @typedef {{kernel: string, stage: string, key: string, hash: string, layouts: string[],
 *   bindings: Binding[], code: string}} Variant
 */

/**
 * @param {string} path of reflection.json
 * @returns {{variants: Variant[], missing: {kernel: string, why: string}[]}}
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
        layouts: kernel.layouts,
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

/**
 * The bind group layouts of a compute kernel, one for each set, and empty ones where it uses none.
 * @param {GPUDevice} device
 * @param {Variant} variant
 */
export function bindGroupLayouts(device, variant) {
  return variant.layouts.map((_, set) =>
    device.createBindGroupLayout({
      entries: variant.bindings
        .filter((binding) => binding.set === set)
        .map(({ entry, kind, access }) => ({
          binding: entry,
          visibility: GPUShaderStage.COMPUTE,
          ...resourceLayout(kind, access),
        })),
    }),
  );
}

function resourceLayout(kind, access) {
  switch (kind) {
    case "storageBuffer":
      return { buffer: { type: access === "read" ? "read-only-storage" : "storage" } };
    case "uniformBuffer":
      return { buffer: { type: "uniform" } };
    case "sampler":
      return { sampler: {} };
    case "sampledTexture":
      return { texture: { sampleType: "float" } };
    default:
      throw new Error(`a compute kernel with a resource of kind ${kind}`);
  }
}
