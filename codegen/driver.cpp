#include "codegen/driver.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <thread>

#include "codegen/cache.h"
#include "codegen/file_io.h"
#include "codegen/hash.h"
#include "codegen/include_scan.h"
#include "codegen/names.h"
#include "codegen/process.h"
#include "codegen/spirv_reader.h"
#include "codegen/unit.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

// Counts up when the same tool and input give another result for a reason that no hash sees.
constexpr uint64_t kCacheFormat = 1;
constexpr uint64_t kCacheBytes = uint64_t{1} << 30;

// Guaranteed by Vulkan, GL and GLES for one constant block.
constexpr uint32_t kUniformBlockBytes = 16384;

struct Unit {
  const ManifestKernel* kernel = nullptr;
  Permutation permutation;
  std::string key;
  FrontEndResult front;
  BackEndResult back;
  ModuleReflection reflection;
  bool reflected = false;
  bool ran = false;  // a child process worked for it
};

class Builder {
 public:
  explicit Builder(const BuildOptions& options)
      : options_(options),
        baseDir_(fs::absolute(options.manifest).lexically_normal().parent_path()),
        cache_(cacheDir()),
        scanner_(baseDir_, absolute(options.includeDirs)) {}

  BuildResult run() {
    result_.program.manifest = readManifest(options_.manifest, result_.diagnostics);
    const Manifest& manifest = result_.program.manifest;
    for (const ManifestKernel& kernel : manifest.kernels) {
      // Groups that do not exist were reported; without one there is no plan to make.
      if (kernel.group >= manifest.groups.size()) continue;
      for (Permutation& permutation : kernel.permutations()) {
        Unit unit;
        unit.kernel = &kernel;
        unit.key = permutationKey(kernel, permutation);
        unit.permutation = std::move(permutation);
        units_.push_back(std::move(unit));
      }
    }
    result_.permutations = units_.size();
    if (const std::optional<std::string> tool = readWholeFile(options_.tool)) {
      toolHash_ = sha256Hex(*tool);
    } else {
      result_.diagnostics.error(manifest.file, 1, "PK410",
                                "cannot read the tool " + options_.tool.string());
      return finish();
    }
    scratch_ = cacheDir() / ("run-" + std::to_string(getpid()));
    std::error_code error;
    fs::create_directories(scratch_, error);
    if (error) {
      result_.diagnostics.error(
          manifest.file, 1, "PK410",
          "cannot make the folder " + scratch_.string() + ": " + error.message());
      return finish();
    }
    compile();
    fs::remove_all(scratch_, error);
    cache_.prune(kCacheBytes);
    return finish();
  }

 private:
  static std::vector<fs::path> absolute(const std::vector<fs::path>& paths) {
    std::vector<fs::path> result;
    for (const fs::path& path : paths) result.push_back(fs::absolute(path).lexically_normal());
    return result;
  }

  fs::path cacheDir() const {
    return fs::absolute(options_.cacheDir.empty() ? options_.outputDir / "cache"
                                                  : options_.cacheDir);
  }

  void compile() {
    for (const ManifestKernel& kernel : result_.program.manifest.kernels) {
      closures_[kernel.name] = scanner_.closure(kernel.file);
    }
    forEachUnit([this](Unit& unit) { runFrontEnd(unit); });
    report([](const Unit& unit) -> const Diagnostics& { return unit.front.diagnostics; });

    LayoutPlan plan(result_.program.manifest);
    Diagnostics planDiagnostics;
    for (Unit& unit : units_) {
      const std::optional<SpirvReader> module = SpirvReader::parse(unit.front.spirv);
      if (!module) continue;
      unit.reflection = reflectModule(*module);
      unit.reflected = true;
      plan.add(*unit.kernel, unit.reflection, unit.front, planDiagnostics);
    }
    plan.assign(planDiagnostics);
    result_.diagnostics.append(planDiagnostics);
    collectStructs();
    // With two resources in one slot the patches would be ambiguous.
    if (!planDiagnostics.hasErrors()) {
      forEachUnit([&](Unit& unit) {
        if (unit.reflected) runBackEnd(unit, plan);
      });
      report([](const Unit& unit) -> const Diagnostics& { return unit.back.diagnostics; });
      collectVariants(plan);
    }
    result_.program.layouts = plan.layouts();
    for (const Unit& unit : units_) ++(unit.ran ? result_.compiled : result_.fromCache);
  }

  void forEachUnit(const std::function<void(Unit&)>& work) {
    unsigned jobs = options_.jobs != 0 ? options_.jobs : std::thread::hardware_concurrency();
    jobs = std::clamp(jobs, 1u, static_cast<unsigned>(std::max<size_t>(units_.size(), 1)));
    std::atomic<size_t> next{0};
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < jobs; ++i) {
      threads.emplace_back([&] {
        for (size_t u = next++; u < units_.size(); u = next++) work(units_[u]);
      });
    }
  }

  // Runs a job in a child process. The result is what the child left, even when it crashed.
  template <class Result>
  std::optional<Result> runChild(Unit& unit, const std::string& step, const std::string& job,
                                 std::optional<Result> (*decode)(const std::string&),
                                 const SourceLocation& where) {
    unit.ran = true;
    const std::string stem = std::to_string(&unit - units_.data()) + "-" + step;
    const fs::path jobFile = scratch_ / (stem + ".job");
    const fs::path resultFile = scratch_ / (stem + ".result");
    const fs::path logFile = scratch_ / (stem + ".log");
    ProcessResult process;
    if (writeWholeFile(jobFile, job)) {
      process = runProcess({options_.tool.string(), "unit", jobFile.string(), resultFile.string()},
                           logFile, options_.timeout);
    } else {
      process.reason = "cannot write " + jobFile.string();
    }
    const std::optional<std::string> text = readWholeFile(resultFile);
    std::optional<Result> result = text ? decode(*text) : std::nullopt;
    const bool ended = process.end == ProcessResult::End::kExited && process.exitStatus == 0;
    if (!result) result.emplace();
    // An error that was found before the crash is the better explanation.
    if (!(ended && result->complete) && !result->diagnostics.hasErrors()) {
      std::string message = "the " + step + " crashed on kernel '" + unit.kernel->name + "'";
      if (process.end == ProcessResult::End::kTimedOut) {
        message = "the " + step + " did not finish kernel '" + unit.kernel->name + "'";
      } else if (process.end != ProcessResult::End::kCrashed) {
        message = "the " + step + " failed on kernel '" + unit.kernel->name + "'";
        if (process.reason.empty()) {
          process.reason = "exit status " + std::to_string(process.exitStatus);
        }
      }
      message += ": " + process.reason;
      const std::string log = readWholeFile(logFile).value_or("");
      if (!log.empty()) message += "; it said: " + log.substr(0, log.find('\n'));
      result->diagnostics.error(where.file, where.line, "PK411", message);
    }
    return result;
  }

  Sha256 startKey(const std::string& step) const {
    Sha256 hash;
    hash.field(step).field(kCacheFormat).field(toolHash_);
    hash.field(frontEndVersion()).field(backEndVersion());
    return hash;
  }

  void runFrontEnd(Unit& unit) {
    const ManifestKernel& kernel = *unit.kernel;
    FrontEndJob job;
    job.source.baseDir = baseDir_;
    job.source.file = kernel.file;
    job.source.entry = kernel.name;
    job.source.stage = kernel.stage;
    for (size_t i = 0; i < kernel.axes.size(); ++i) {
      job.source.macros.emplace_back(macroName(kernel.axes[i].name),
                                     std::to_string(unit.permutation[i]));
    }
    job.source.includeDirs = absolute(options_.includeDirs);
    job.kernel = kernel.name;
    job.desktopTier = kernel.desktopTier;
    job.precise = kernel.precise;

    Sha256 hash = startKey("front end");
    hash.field(kernel.file).field(kernel.name).field(static_cast<uint64_t>(kernel.stage));
    hash.field(uint64_t{kernel.desktopTier}).field(uint64_t{kernel.precise});
    hash.field(uint64_t{job.source.macros.size()});
    for (const auto& [name, value] : job.source.macros) hash.field(name).field(value);
    const std::vector<std::string>& closure = closures_.at(kernel.name);
    for (const std::string& name : closure) hash.field(name).field(scanner_.contentHash(name));
    const std::string key = hex(hash.finish());
    if (const std::optional<std::string> cached = cache_.load(key)) {
      if (std::optional<FrontEndResult> result = decodeFrontEndResult(*cached)) {
        unit.front = std::move(*result);
        return;
      }
    }
    unit.front = *runChild(unit, "front end", encode(job), &decodeFrontEndResult,
                           SourceLocation{kernel.file, 1});
    for (const std::string& file : unit.front.files) {
      if (std::find(closure.begin(), closure.end(), displayName(baseDir_ / file, baseDir_)) !=
          closure.end()) {
        continue;
      }
      unit.front.diagnostics.error(kernel.file, 1, "PK409",
                                   "'" + file +
                                       "' is included through a macro: write the name in the "
                                       "#include line, so that a change of the file is noticed");
    }
    if (!unit.front.diagnostics.hasErrors()) cache_.store(key, encode(unit.front));
  }

  void runBackEnd(Unit& unit, const LayoutPlan& plan) {
    const ManifestKernel& kernel = *unit.kernel;
    BackEndJob job;
    job.kernel = kernel.name;
    job.file = kernel.file;
    job.entry = kernel.name;
    job.entryLocation = locate(unit, kernel.name);
    job.stage = kernel.stage;
    job.desktopTier = kernel.desktopTier;
    job.precise = kernel.precise;
    job.spirv = unit.front.spirv;
    job.log = unit.front.log;
    job.patches = plan.patches(kernel, unit.reflection);

    const std::string encoded = encode(job);
    const std::string key = hex(startKey("back end").field(encoded).finish());
    if (const std::optional<std::string> cached = cache_.load(key)) {
      if (std::optional<BackEndResult> result = decodeBackEndResult(*cached)) {
        unit.back = std::move(*result);
        return;
      }
    }
    unit.back = *runChild(unit, "back end", encoded, &decodeBackEndResult, job.entryLocation);
    if (!unit.back.diagnostics.hasErrors()) cache_.store(key, encode(unit.back));
  }

  static SourceLocation locate(const Unit& unit, const std::string& name) {
    const auto found = unit.front.declarations.find(name);
    return found != unit.front.declarations.end() ? found->second
                                                  : SourceLocation{unit.kernel->file, 1};
  }

  // Adds the messages of all units. One that not all permutations of its kernel have names those
  // that do.
  void report(const std::function<const Diagnostics&(const Unit&)>& messages) {
    std::map<const ManifestKernel*, std::map<Diagnostic, std::vector<std::string>>> found;
    std::map<const ManifestKernel*, size_t> count;
    for (const Unit& unit : units_) {
      ++count[unit.kernel];
      std::set<Diagnostic> own;
      for (const Diagnostic& diagnostic : messages(unit).items()) own.insert(diagnostic);
      for (const Diagnostic& diagnostic : own) found[unit.kernel][diagnostic].push_back(unit.key);
    }
    for (const auto& [kernel, diagnostics] : found) {
      for (const auto& [diagnostic, keys] : diagnostics) {
        Diagnostic full = diagnostic;
        if (keys.size() < count[kernel]) {
          full.message += " (kernel '" + kernel->name + "' with " + keys.front();
          if (keys.size() > 1) full.message += " and " + std::to_string(keys.size() - 1) + " more";
          full.message += ")";
        }
        result_.diagnostics.add(std::move(full));
      }
    }
  }

  void collectStructs() {
    struct Origin {
      StructLayout layout;
      SourceLocation where;
      std::string kernel;
      const FrontEndResult* front;
    };
    std::map<std::string, Origin> origins;
    for (const Unit& unit : units_) {
      for (const std::string& name : unit.reflection.structConflicts) {
        const SourceLocation where = locate(unit, name);
        result_.diagnostics.error(where.file, where.line, "PK601",
                                  "struct '" + name + "' has two memory layouts in kernel '" +
                                      unit.kernel->name + "': use one struct for each buffer kind");
      }
      for (const auto& [name, layout] : unit.reflection.structs) {
        const SourceLocation where = locate(unit, name);
        const auto [found, added] =
            origins.emplace(name, Origin{layout, where, unit.kernel->name, &unit.front});
        if (added || found->second.layout == layout) continue;
        const Origin& other = found->second;
        result_.diagnostics.error(where.file, where.line, "PK601",
                                  "struct '" + name + "' of kernel '" + unit.kernel->name +
                                      "' differs from the one of kernel '" + other.kernel +
                                      "' at " + other.where.file + ":" +
                                      std::to_string(other.where.line));
      }
    }
    std::set<std::string> done;
    const std::function<void(const std::string&)> add = [&](const std::string& name) {
      const auto found = origins.find(name);
      if (found == origins.end() || !done.insert(name).second) return;
      const Origin& origin = found->second;
      for (const StructMember& member : origin.layout.members) {
        if (!member.structName.empty()) add(member.structName);
      }
      if (origin.layout.isBlock && origin.layout.size > kUniformBlockBytes) {
        result_.diagnostics.error(origin.where.file, origin.where.line, "PK701",
                                  "'" + name + "' has " + std::to_string(origin.layout.size) +
                                      " bytes, devices guarantee " +
                                      std::to_string(kUniformBlockBytes) +
                                      " for a constant block: use a StructuredBuffer");
      }
      Diagnostics problems;
      std::optional<HostStruct> host = makeHostStruct(origin.layout, origin.where, problems);
      for (const Diagnostic& diagnostic : problems.items()) {
        // The source checks name the member's line, when they understand the source.
        if (diagnostic.code == "PK607" && origin.front->diagnostics.hasCode("PK125")) continue;
        if (diagnostic.code == "PK608" && origin.front->diagnostics.hasCode("PK124")) continue;
        result_.diagnostics.add(diagnostic);
      }
      if (host) result_.program.structs.push_back(std::move(*host));
    };
    for (const auto& [name, origin] : origins) add(name);
  }

  void collectVariants(LayoutPlan& plan) {
    for (const ManifestKernel& kernel : result_.program.manifest.kernels) {
      KernelOutput output;
      output.kernel = kernel;
      std::map<std::vector<uint32_t>, size_t> known;
      for (const Unit& unit : units_) {
        if (unit.kernel != &kernel || !unit.reflected) continue;
        collectSpecConstants(unit, output);
        const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
        if (!module || unit.back.spirv.empty()) continue;
        const auto [found, added] = known.emplace(unit.back.spirv, output.variants.size());
        if (!added) {
          output.variants[found->second].permutations.push_back(unit.permutation);
          continue;
        }
        output.variants.push_back(makeVariant(unit, *module, plan));
      }
      std::sort(output.specConstants.begin(), output.specConstants.end(),
                [](const SpecConstantInfo& a, const SpecConstantInfo& b) { return a.id < b.id; });
      result_.distinct += output.variants.size();
      result_.program.kernels.push_back(std::move(output));
    }
  }

  static VariantOutput makeVariant(const Unit& unit, const SpirvReader& module, LayoutPlan& plan) {
    VariantOutput variant;
    variant.permutations.push_back(unit.permutation);
    variant.spirv = unit.back.spirv;
    variant.glsl = unit.back.glsl;
    variant.essl = unit.back.essl;
    variant.hash = shortHash(Sha256().words(variant.spirv).finish());
    const ModuleReflection reflection = reflectModule(module);
    std::copy_n(reflection.groupSize, 3, variant.groupSize);
    variant.sharedBytes = reflection.sharedBytes;
    for (const auto& [id, access] : resourceAccess(module)) {
      const uint32_t set = module.decoration(id, SpvDecorationDescriptorSet).value_or(0);
      const uint32_t binding = module.decoration(id, SpvDecorationBinding).value_or(0);
      std::vector<PlannedEntry>& entries = plan.layout(unit.kernel->group, set).entries;
      if (binding >= entries.size()) continue;
      entries[binding].access = entries[binding].access | access;
      variant.bindings.push_back({set, binding, access});
    }
    std::sort(variant.bindings.begin(), variant.bindings.end(),
              [](const BindingUse& a, const BindingUse& b) {
                return std::tie(a.set, a.entry) < std::tie(b.set, b.entry);
              });
    return variant;
  }

  void collectSpecConstants(const Unit& unit, KernelOutput& output) {
    for (const SpecConstantInfo& constant : unit.reflection.specConstants) {
      bool known = false;
      for (const SpecConstantInfo& other : output.specConstants) {
        if (other == constant) {
          known = true;
        } else if (other.id == constant.id || other.name == constant.name) {
          const SourceLocation where = locate(unit, constant.name);
          result_.diagnostics.error(where.file, where.line, "PK508",
                                    "specialization constants '" + constant.name + "' (id " +
                                        std::to_string(constant.id) + ") and '" + other.name +
                                        "' (id " + std::to_string(other.id) + ") of kernel '" +
                                        unit.kernel->name +
                                        "' have the same id, name or another default");
          known = true;
        }
      }
      if (known) continue;
      if (constant.type == ScalarType::kOther || !isIdentifier(hostName(constant.name))) {
        const SourceLocation where = locate(unit, constant.name);
        result_.diagnostics.error(where.file, where.line, "PK509",
                                  "specialization constant '" + constant.name +
                                      "' must be a named bool, int, uint or float");
        continue;
      }
      output.specConstants.push_back(constant);
    }
  }

  BuildResult finish() {
    if (!result_.diagnostics.hasErrors()) writeOutputs();
    // Files are named relative to the manifest so far; a person wants a path that opens.
    Diagnostics shown;
    for (Diagnostic diagnostic : result_.diagnostics.sorted()) {
      if (fs::path(diagnostic.file).is_relative()) {
        diagnostic.file =
            (options_.manifest.parent_path() / diagnostic.file).lexically_normal().generic_string();
      }
      shown.add(std::move(diagnostic));
    }
    result_.diagnostics = std::move(shown);
    result_.ok = !result_.diagnostics.hasErrors();
    return std::move(result_);
  }

  void writeOutputs() {
    std::map<fs::path, std::string> files;
    for (auto& [name, text] : emitSources(result_.program)) {
      files[options_.outputDir / name] = std::move(text);
    }
    files[options_.reflectionFile.empty() ? options_.outputDir / "reflection.json"
                                          : options_.reflectionFile] =
        emitReflection(result_.program);
    for (const auto& [path, text] : files) require(writeIfChanged(path, text), path);
    if (!options_.depFile.empty()) {
      require(writeWholeFile(options_.depFile, dependencies()), options_.depFile);
    }
    if (!options_.stampFile.empty() && !result_.diagnostics.hasErrors()) {
      require(writeWholeFile(options_.stampFile, ""), options_.stampFile);
    }
  }

  void require(bool written, const fs::path& path) {
    if (written) return;
    result_.diagnostics.error(result_.program.manifest.file, 1, "PK412",
                              "cannot write " + path.string());
  }

  // In Make's syntax, which Ninja reads too.
  std::string dependencies() {
    const auto escape = [](const fs::path& path) {
      std::string text;
      for (const char c : path.generic_string()) {
        if (c == ' ' || c == '#') text += '\\';
        if (c == '$') text += '$';
        text += c;
      }
      return text;
    };
    std::set<fs::path> inputs{fs::absolute(options_.manifest).lexically_normal()};
    for (const auto& [kernel, closure] : closures_) {
      for (const std::string& name : closure) inputs.insert((baseDir_ / name).lexically_normal());
    }
    std::string text = escape(fs::absolute(options_.stampFile).lexically_normal()) + ":";
    for (const fs::path& input : inputs) text += " \\\n  " + escape(input);
    return text + "\n";
  }

  const BuildOptions& options_;
  fs::path baseDir_;
  fs::path scratch_;
  std::string toolHash_;
  Cache cache_;
  IncludeScanner scanner_;
  std::map<std::string, std::vector<std::string>> closures_;  // by kernel
  std::vector<Unit> units_;
  BuildResult result_;
};

}  // namespace

std::string BuildResult::summary() const {
  return "pelage-codegen: " + std::to_string(permutations) + " permutations, " +
         std::to_string(compiled) + " compiled, " + std::to_string(fromCache) + " from cache, " +
         std::to_string(distinct) + " distinct";
}

BuildResult build(const BuildOptions& options) { return Builder(options).run(); }

}  // namespace pelage::codegen
