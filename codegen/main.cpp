// pelage-codegen: HLSL kernels to SPIR-V, GLSL, layouts and host structs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "codegen/driver.h"
#include "codegen/process.h"
#include "codegen/unit.h"

namespace {

int buildCommand(pelage::codegen::BuildOptions options, bool quiet) {
  options.tool = pelage::codegen::currentExecutable();
  const pelage::codegen::BuildResult result = pelage::codegen::build(options);
  std::fputs(result.diagnostics.format().c_str(), stderr);
  if (!result.ok) return 1;
  if (!quiet) std::printf("%s\n", result.summary().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app(
        "Compiles the kernels of a manifest to SPIR-V, GLSL 450, ESSL 320, layout tables and "
        "host structs.",
        "pelage-codegen");
    pelage::codegen::BuildOptions options;
    bool quiet = false;
    long timeout = options.timeout.count();
    app.add_option("manifest", options.manifest, "The manifest, a JSON file")
        ->check(CLI::ExistingFile);
    app.add_option("-o,--output", options.outputDir,
                   "Folder for include/<namespace>/*.h, *.cpp and code/*.cpp");
    app.add_option("-I,--include", options.includeDirs, "Folder to search for included files")
        ->allow_extra_args(false);
    app.add_option("--reflection", options.reflectionFile,
                   "File for the reflection (default: reflection.json in the output folder)");
    app.add_option("--cache", options.cacheDir,
                   "Folder of compiled permutations (default: cache in the output folder)");
    CLI::Option* stamp =
        app.add_option("--stamp", options.stampFile, "File to touch after a success");
    app.add_option("-M,--depfile", options.depFile, "File for the dependencies of the stamp")
        ->needs(stamp);
    app.add_option("--wgsl", options.wgslTranslator,
                   "Write WGSL, too: codegen/wgsl/translate.mjs beside its installed packages")
        ->check(CLI::ExistingFile);
    app.add_option("--node", options.node, "Node.js for --wgsl")->capture_default_str();
    app.add_flag("--msl", options.msl,
                 "Write MSL, too: msl/*.metal, metal.h with its slots, both in the reflection");
    app.add_flag("--hlsl", options.hlsl,
                 "Write what a compiler of shader model 6 needs: dxc.txt, and the reflection");
    app.add_option("-j,--jobs", options.jobs, "Permutations at a time (default: hardware threads)");
    app.add_option("--timeout", timeout, "Seconds that one permutation may take")
        ->check(CLI::Range(1, 86400))
        ->capture_default_str();
    app.add_flag("--keep-names", options.keepNames,
                 "Keep names and lines in SPIR-V, and indentation in GLSL: for debugging");
    app.add_flag("-q,--quiet", quiet, "No summary line");

    // The tool runs itself as a worker, so that a crash of a compiler ends only the child.
    const CLI::App* worker = app.add_subcommand("worker")->group("");

    CLI11_PARSE(app, argc, argv);
    if (worker->parsed()) return pelage::codegen::serveJobs(pelage::codegen::runUnit);
    if (options.manifest.empty() || options.outputDir.empty()) {
      std::fputs("pelage-codegen: give a manifest and --output; --help lists everything\n", stderr);
      return 2;
    }
    options.timeout = std::chrono::seconds(timeout);
    return buildCommand(std::move(options), quiet);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "pelage-codegen: %s\n", e.what());
    return 2;
  }
}
