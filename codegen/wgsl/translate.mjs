// Translates SPIR-V to WGSL with naga: node translate.mjs FOLDER. Each FOLDER/x.spv becomes x.wgsl,
// or x.error with the reason. pelage-codegen runs it once for all kernels of a manifest.
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { parseSpirv, validate, writeWgsl } from "naga-wasm";
import { agreeOnBranches } from "./uniform.mjs";

/**
 * Gives inputs of the entry point to the function that naga calls from it as parameters. Naga hands
 * them on in private variables, which WGSL never takes for uniform: a kernel whose barriers depend
 * on its group's number would be refused.
 * @param {string} wgsl
 * @returns {string}
 */
function passInputs(wgsl) {
  const inputs = [...wgsl.matchAll(/^    (global\w*) = param\w*;\n/gm)].map(([line, name]) => {
    const declaration = new RegExp(`^var<private> ${name}: ([^;=]+);\\n`, "m");
    return { line, name, declaration, type: declaration.exec(wgsl)?.[1] };
  });
  if (inputs.length === 0 || inputs.some(({ type }) => !type)) return wgsl;
  let text = wgsl;
  for (const { line, declaration } of inputs) text = text.replace(line, "").replace(declaration, "");
  const values = inputs.map(({ line }) => /= (\w+);/.exec(line)[1]);
  const parameters = inputs.map(({ name, type }) => `${name}_in: ${type}`);
  const variables = inputs.map(({ name }) => `    let ${name} = ${name}_in;\n`);
  return text
    .replace("fn function_() {\n", () => `fn function_(${parameters.join(", ")}) {\n${variables.join("")}`)
    .replace("    function_();\n", () => `    function_(${values.join(", ")});\n`);
}

/**
 * Leaves y of clip space upwards, as kernels write it and WebGPU wants it. naga negates it, for it takes
 * y of SPIR-V to be downwards; on Vulkan, the viewport has a negative height instead.
 * @param {string} wgsl
 * @returns {string}
 */
function keepClipSpace(wgsl) {
  const entry = wgsl.indexOf("\n@vertex");
  if (entry < 0) return wgsl;
  const flip = /^ {4}let (_e\d+) = (\w+)\.y;\n {4}\2\.y = -\(\1\);\n/m;
  const text = wgsl.slice(entry);
  if (!flip.test(text)) throw new Error("naga has not negated y of clip space");
  return wgsl.slice(0, entry) + text.replace(flip, "");
}

const folder = process.argv[2];
for (const file of readdirSync(folder).filter((name) => name.endsWith(".spv"))) {
  const stem = join(folder, file.slice(0, -".spv".length));
  try {
    const module = parseSpirv(new Uint8Array(readFileSync(join(folder, file))));
    const info = validate(module);
    writeFileSync(`${stem}.wgsl`, agreeOnBranches(passInputs(keepClipSpace(writeWgsl(module, info)))));
    info.free();
    module.free();
  } catch (error) {
    writeFileSync(`${stem}.error`, error.formatted ?? String(error));
  }
}
