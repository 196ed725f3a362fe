#include "codegen/driver.h"

#include <fmt/format.h>
#include <unistd.h>

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "codegen/cache.h"
#include "codegen/collect.h"
#include "codegen/compiler.h"
#include "codegen/device_limits.h"
#include "codegen/file_io.h"
#include "codegen/hash.h"
#include "codegen/include_scan.h"
#include "codegen/variant_code.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kCacheBytes = uint64_t{1} << 30;

fs::path normalized(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

// Empty if it cannot be read. Read once: builds of one process have a tool that stays as it is.
std::string hashOfTool(const fs::path& tool) {
  static std::mutex mutex;
  static std::map<fs::path, std::string> known;
  const std::lock_guard lock(mutex);
  std::string& hash = known[tool];
  if (hash.empty()) {
    if (const std::optional<std::string> bytes = readWholeFile(tool)) hash = sha256Hex(*bytes);
  }
  return hash;
}

std::vector<Unit> listUnits(const Manifest& manifest) {
  std::vector<Unit> units;
  for (const ManifestKernel& kernel : manifest.kernels) {
    // Groups that do not exist were reported; without one there is no plan to make.
    if (kernel.group >= manifest.groups.size()) continue;
    for (const Permutation& permutation : kernel.permutations()) {
      Unit& unit = units.emplace_back();
      unit.kernel = &kernel;
      unit.permutation = permutation;
      unit.key = permutationKey(kernel, permutation);
    }
  }
  return units;
}

// Adds the messages of a step. One that not all permutations of its kernel have names those that
// do.
template <class Result>
void report(const std::vector<Unit>& units, Result Unit::*step, Diagnostics& diagnostics) {
  std::map<const ManifestKernel*, std::map<Diagnostic, std::vector<std::string>>> found;
  std::map<const ManifestKernel*, size_t> count;
  for (const Unit& unit : units) {
    ++count[unit.kernel];
    const std::vector<Diagnostic>& items = (unit.*step).diagnostics.items();
    for (const Diagnostic& diagnostic : std::set<Diagnostic>(items.begin(), items.end()))
      found[unit.kernel][diagnostic].push_back(unit.key);
  }
  for (const auto& [kernel, messages] : found) {
    for (const auto& [diagnostic, keys] : messages) {
      Diagnostic full = diagnostic;
      if (keys.size() < count[kernel]) {
        full.message += " (kernel '" + kernel->name + "' with " + keys.front();
        if (keys.size() > 1) full.message += " and " + std::to_string(keys.size() - 1) + " more";
        full.message += ")";
      }
      diagnostics.add(std::move(full));
    }
  }
}

void compile(const BuildOptions& options, const fs::path& scratch, const Cache& cache,
             Compiler& compiler, std::vector<Unit>& units, BuildResult& result) {
  Program& program = result.program;
  Diagnostics& diagnostics = result.diagnostics;
  for (const ManifestConstants& listed : program.manifest.constants) {
    ConstantsResult found = compiler.constants(listed);
    diagnostics.append(found.diagnostics);
    program.constants.push_back({listed.file, listed.space, std::move(found.constants)});
  }
  compiler.frontEnd(units);
  report(units, &Unit::front, diagnostics);

  LayoutPlan plan(program.manifest);
  Diagnostics planDiagnostics;
  for (const Unit& unit : units)
    if (unit.reflection) plan.add(unit, planDiagnostics);
  plan.assign(planDiagnostics);
  diagnostics.append(planDiagnostics);
  program.structs = collectStructs(units, diagnostics);
  // With two resources in one slot the patches would be ambiguous.
  if (!planDiagnostics.hasErrors()) {
    compiler.backEnd(units, plan, program.manifest);
    report(units, &Unit::back, diagnostics);
    checkDraws(units, program.manifest, diagnostics);
    if (program.manifest.webgpu) checkWebgpu(units, diagnostics);
    program.kernels = collectKernels(program.manifest, units, options.keepNames, plan, diagnostics);
    program.wgsl = !options.wgslTranslator.empty() && program.manifest.webgpu;
    program.msl = options.msl;
    program.hlsl = options.hlsl;
    if (program.wgsl)
      translateToWgsl(options, scratch / "wgsl", cache, units, program, diagnostics);
    if (program.msl) translateToMsl(compiler.threads(), units, program.kernels, diagnostics);
    packKernels(compiler.threads(), options.keepNames, cache, program.kernels, diagnostics);
  }
  compiler.finish(program.manifest.file, diagnostics);
  program.layouts = plan.layouts();
  for (const KernelOutput& kernel : program.kernels) result.distinct += kernel.variants.size();
  for (const Unit& unit : units) ++(unit.ran ? result.compiled : result.fromCache);
}

// In Make's syntax, which Ninja reads too.
std::string dependencies(const fs::path& target, const std::set<fs::path>& inputs) {
  const auto escape = [](const fs::path& path) {
    std::string text;
    for (const char c : path.generic_string()) {
      if (c == ' ' || c == '#') text += '\\';
      if (c == '$') text += '$';
      text += c;
    }
    return text;
  };
  std::string text = escape(target) + ":";
  for (const fs::path& input : inputs) text += " \\\n  " + escape(input);
  return text + "\n";
}

void writeOutputs(const BuildOptions& options, std::set<fs::path> inputs, const Program& program,
                  Diagnostics& diagnostics) {
  const auto require = [&](bool written, const fs::path& path) {
    if (!written)
      diagnostics.error(program.manifest.file, 1, "PK412", "cannot write " + path.string());
  };
  std::map<std::string, std::string> texts = emitSources(program);
  texts.merge(emitCode(program));
  if (program.msl) texts.merge(emitMetal(program));
  if (program.hlsl) texts["dxc.txt"] = emitDxcLines(program, options.includeDirs);
  std::map<fs::path, std::string> files;
  for (auto& [name, text] : texts) files[options.outputDir / name] = std::move(text);
  files[options.reflectionFile.empty() ? options.outputDir / "reflection.json"
                                       : options.reflectionFile] = emitReflection(program);
  for (const auto& [path, text] : files) require(writeIfChanged(path, text), path);
  if (!options.depFile.empty()) {
    inputs.insert(normalized(options.manifest));
    require(writeWholeFile(options.depFile, dependencies(normalized(options.stampFile), inputs)),
            options.depFile);
  }
  if (!options.stampFile.empty() && !diagnostics.hasErrors())
    require(writeWholeFile(options.stampFile, ""), options.stampFile);
}

// Files are named relative to the manifest so far; a person wants a path that opens.
Diagnostics shown(const Diagnostics& diagnostics, const fs::path& manifest) {
  Diagnostics result;
  for (Diagnostic diagnostic : diagnostics.sorted()) {
    if (fs::path(diagnostic.file).is_relative()) {
      diagnostic.file =
          (manifest.parent_path() / diagnostic.file).lexically_normal().generic_string();
    }
    result.add(std::move(diagnostic));
  }
  return result;
}

}  // namespace

std::string BuildResult::summary() const {
  return fmt::format("pelage-codegen: {} permutations, {} compiled, {} from cache, {} distinct",
                     permutations, compiled, fromCache, distinct);
}

BuildResult build(const BuildOptions& options) {
  BuildResult result;
  Diagnostics& diagnostics = result.diagnostics;
  const Manifest& manifest = result.program.manifest = readManifest(options.manifest, diagnostics);
  std::vector<Unit> units = listUnits(manifest);
  result.permutations = units.size();

  FrontEndInput source;
  source.baseDir = normalized(options.manifest).parent_path();
  for (const fs::path& dir : options.includeDirs) source.includeDirs.push_back(normalized(dir));
  IncludeScanner scanner(source.baseDir, source.includeDirs);
  const fs::path cacheDir =
      fs::absolute(options.cacheDir.empty() ? options.outputDir / "cache" : options.cacheDir);
  const Cache cache(cacheDir);
  const fs::path scratch = cacheDir / ("run-" + std::to_string(getpid()));
  const std::string toolHash = hashOfTool(options.tool);
  std::error_code error;
  if (toolHash.empty()) {
    diagnostics.error(manifest.file, 1, "PK410", "cannot read the tool " + options.tool.string());
  } else if (fs::create_directories(scratch, error); error) {
    diagnostics.error(manifest.file, 1, "PK410",
                      "cannot make the folder " + scratch.string() + ": " + error.message());
  } else {
    Compiler compiler(options, source, scratch, toolHash, cache, scanner);
    compile(options, scratch, cache, compiler, units, result);
    fs::remove_all(scratch, error);
    cache.prune(kCacheBytes);
  }
  if (!diagnostics.hasErrors()) writeOutputs(options, scanner.files(), result.program, diagnostics);
  result.diagnostics = shown(diagnostics, options.manifest);
  result.ok = !diagnostics.hasErrors();
  return result;
}

}  // namespace pelage::codegen
