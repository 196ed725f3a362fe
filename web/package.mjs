// Writes the layout of the npm package: node package.mjs SITE FOLDER TSC LICENSE
import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, rmSync } from "node:fs";
import { join } from "node:path";

const [site, folder, tsc, license] = process.argv.slice(2);
if (!license) {
  console.error("usage: node package.mjs SITE FOLDER TSC LICENSE");
  process.exit(2);
}
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
cpSync(join(import.meta.dirname, "package"), folder, { recursive: true });
for (const file of ["executor.mjs", "kernels.json", "pelage.wasm", "view.mjs", "web_scene.mjs"])
  cpSync(join(site, file), join(folder, file));
cpSync(license, join(folder, "LICENSE"));

// The types that the comments state, as index.d.mts and others.
const options = ["--allowJs", "--declaration", "--emitDeclarationOnly", "--strict", "--target", "es2022", "--module", "esnext"];
const types = ["--lib", "es2022,dom,dom.iterable", "--types", "@webgpu/types", "--typeRoots", join(tsc, "../../..")];
execFileSync(process.execPath, [tsc, ...options, ...types, "--outDir", folder, join(folder, "index.mjs")], { stdio: "inherit" });
