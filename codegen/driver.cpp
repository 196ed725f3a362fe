#include "codegen/driver.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <map>
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
#include "codegen/pack.h"
#include "codegen/process.h"
#include "codegen/spirv_reader.h"
#include "codegen/unit.h"
#include "codegen/wgsl_module.h"

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

class Builder {
 public:
  explicit Builder(const BuildOptions& options)
      : options_(options),
        baseDir_(fs::absolute(options.manifest).lexically_normal().parent_path()),
        cache_(cacheDir()),
        scanner_(baseDir_, absolute(options.includeDirs)) {
    const unsigned jobs = options.jobs != 0 ? options.jobs : std::thread::hardware_concurrency();
    for (unsigned i = 0; i < std::max(jobs, 1u); ++i) workers_.emplace_back(options.tool);
  }

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
    toolHash_ = hashOfTool(options_.tool);
    if (toolHash_.empty()) {
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
    collectConstants();
    forEachUnit([this](Unit& unit, Worker& worker) { runFrontEnd(unit, worker); });
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
      // The numbers of vertex kernels' buffers follow those of the pixel kernels.
      for (const bool vertex : {false, true}) {
        forEachUnit([&](Unit& unit, Worker& worker) {
          if (unit.reflected && (unit.kernel->stage == Stage::kVertex) == vertex)
            runBackEnd(unit, plan, worker);
        });
      }
      report([](const Unit& unit) -> const Diagnostics& { return unit.back.diagnostics; });
      checkPairs();
      checkWebgpu();
      collectVariants(plan);
      translateToWgsl();
      translateToMsl();
      packKernels();
    }
    finishWorkers();
    result_.program.layouts = plan.layouts();
    for (const Unit& unit : units_) ++(unit.ran ? result_.compiled : result_.fromCache);
  }

  void forEachUnit(const std::function<void(Unit&, Worker&)>& work) {
    inParallel<Unit>(units_, [&](Unit& unit, size_t thread) { work(unit, workers_[thread]); });
  }

  // On as many threads as there are workers.
  template <class Item>
  void inParallel(std::vector<Item>& items,
                  const std::function<void(Item&, size_t thread)>& work) const {
    std::atomic<size_t> next{0};
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < std::min(workers_.size(), items.size()); ++i) {
      threads.emplace_back([&, i] {
        for (size_t u = next++; u < items.size(); u = next++) work(items[u], i);
      });
    }
  }

  void finishWorkers() {
    for (Worker& worker : workers_) {
      const ProcessResult process = worker.finish();
      if (process.end == ProcessResult::End::kDone) continue;
      result_.diagnostics.error(result_.program.manifest.file, 1, "PK411",
                                "a compiler crashed at its end: " + process.reason);
    }
  }

  // Runs a job on a kernel or a file in a child process. The result is what the child left, even
  // when it crashed.
  // \param name of the child's files
  template <class Result>
  std::optional<Result> runChild(Worker& worker, const std::string& name, const std::string& step,
                                 const std::string& subject, const std::string& job,
                                 std::optional<Result> (*decode)(const std::string&),
                                 const SourceLocation& where) {
    const std::string stem = (scratch_ / (name + "-" + step)).string();
    const std::string jobFile = stem + ".job";
    ProcessResult process;
    if (writeWholeFile(jobFile, job)) {
      process = worker.run(stem, options_.timeout);
    } else {
      process.reason = "cannot write " + jobFile;
    }
    const std::optional<std::string> text = readWholeFile(stem + ".result");
    std::optional<Result> result = text ? decode(*text) : std::nullopt;
    const bool ended = process.end == ProcessResult::End::kDone;
    if (!result) result.emplace();
    // An error that was found before the crash is the better explanation.
    if (!(ended && result->complete) && !result->diagnostics.hasErrors()) {
      std::string message = "the " + step + " crashed on " + subject;
      if (process.end == ProcessResult::End::kTimedOut) {
        message = "the " + step + " did not finish " + subject;
      } else if (process.end != ProcessResult::End::kCrashed) {
        message = "the " + step + " failed on " + subject;
      }
      message += ": " + process.reason;
      const std::string log = readWholeFile(stem + ".log").value_or("");
      if (!log.empty()) message += "; it said: " + log.substr(0, log.find('\n'));
      result->diagnostics.error(where.file, where.line, "PK411", message);
    }
    return result;
  }

  template <class Result>
  std::optional<Result> runChild(Worker& worker, Unit& unit, const std::string& step,
                                 const std::string& job,
                                 std::optional<Result> (*decode)(const std::string&),
                                 const SourceLocation& where) {
    unit.ran = true;
    return runChild(worker, std::to_string(&unit - units_.data()), step,
                    "kernel '" + unit.kernel->name + "'", job, decode, where);
  }

  void collectConstants() {
    for (const ManifestConstants& listed : result_.program.manifest.constants) {
      const std::vector<std::string> closure = scanner_.closure(listed.file);
      closures_[listed.file] = closure;
      Sha256 hash = startKey("constants");
      hash.field(listed.file);
      for (const std::string& name : closure) hash.field(name).field(scanner_.contentHash(name));
      const std::string key = hex(hash.finish());
      const std::optional<std::string> cached = cache_.load(key);
      std::optional<ConstantsResult> result =
          cached ? decodeConstantsResult(*cached) : std::nullopt;
      if (!result) {
        ConstantsJob job;
        job.source.baseDir = baseDir_;
        job.source.file = listed.file;
        job.source.includeDirs = absolute(options_.includeDirs);
        result = runChild(workers_[0], listed.space, "evaluation of constants",
                          "file '" + listed.file + "'", encode(job), &decodeConstantsResult,
                          SourceLocation{listed.file, 1});
        checkIncludes(listed.file, result->files, closure, result->diagnostics);
        if (!result->diagnostics.hasErrors()) cache_.store(key, encode(*result));
      }
      result_.diagnostics.append(result->diagnostics);
      result_.program.constants.push_back(
          {listed.file, listed.space, std::move(result->constants)});
    }
  }

  // All that was read must be known to the dependency scan.
  void checkIncludes(const std::string& source, const std::vector<std::string>& read,
                     const std::vector<std::string>& closure, Diagnostics& diagnostics) const {
    for (const std::string& file : read) {
      if (std::find(closure.begin(), closure.end(), displayName(baseDir_ / file, baseDir_)) !=
          closure.end()) {
        continue;
      }
      diagnostics.error(source, 1, "PK409",
                        "'" + file +
                            "' is included through a macro: write the name in the #include line, "
                            "so that a change of the file is noticed");
    }
  }

  Sha256 startKey(const std::string& step) const {
    Sha256 hash;
    hash.field(step).field(kCacheFormat).field(toolHash_);
    hash.field(frontEndVersion()).field(backEndVersion());
    return hash;
  }

  void runFrontEnd(Unit& unit, Worker& worker) {
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
    job.precise = kernel.precise;

    Sha256 hash = startKey("front end");
    hash.field(kernel.file).field(kernel.name).field(static_cast<uint64_t>(kernel.stage));
    hash.field(uint64_t{kernel.precise});
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
    unit.front = *runChild(worker, unit, "front end", encode(job), &decodeFrontEndResult,
                           SourceLocation{kernel.file, 1});
    checkIncludes(kernel.file, unit.front.files, closure, unit.front.diagnostics);
    if (!unit.front.diagnostics.hasErrors()) cache_.store(key, encode(unit.front));
  }

  void runBackEnd(Unit& unit, const LayoutPlan& plan, Worker& worker) {
    const ManifestKernel& kernel = *unit.kernel;
    BackEndJob job;
    job.kernel = kernel.name;
    job.file = kernel.file;
    job.entry = kernel.name;
    job.entryLocation = locate(unit, kernel.name);
    job.stage = kernel.stage;
    job.tier = kernel.tierOf(unit.permutation);
    job.precise = kernel.precise;
    job.spirv = unit.front.spirv;
    job.log = unit.front.log;
    job.patches = plan.patches(kernel, unit.reflection);
    job.firstStorageBinding = firstStorageBinding(unit);

    const std::string encoded = encode(job);
    const std::string key = hex(startKey("back end").field(encoded).finish());
    if (const std::optional<std::string> cached = cache_.load(key)) {
      if (std::optional<BackEndResult> result = decodeBackEndResult(*cached)) {
        unit.back = std::move(*result);
        return;
      }
    }
    unit.back =
        *runChild(worker, unit, "back end", encoded, &decodeBackEndResult, job.entryLocation);
    if (!unit.back.diagnostics.hasErrors()) cache_.store(key, encode(unit.back));
  }

  static uint32_t storageBuffers(const Unit& unit) {
    const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
    return module ? static_cast<uint32_t>(storageBufferNumbers(*module, 0).size()) : 0;
  }

  bool canBeDrawn(const Unit& vertex, const Unit& pixel) const {
    return vertex.kernel->stage == Stage::kVertex && pixel.kernel->stage == Stage::kPixel &&
           result_.program.manifest.groupsFit(vertex.kernel->group, pixel.kernel->group);
  }

  // Both stages of a program share GL's binding points.
  uint32_t firstStorageBinding(const Unit& unit) const {
    const auto& own = unit.reflection.resources;
    if (std::none_of(own.begin(), own.end(), [](const Resource& resource) {
          return resource.kind == ResourceKind::kStorageBuffer;
        })) {
      return 0;
    }
    uint32_t first = 0;
    for (const Unit& pixel : units_)
      if (canBeDrawn(unit, pixel)) first = std::max(first, storageBuffers(pixel));
    return first;
  }

  // All pairs of a vertex and a pixel kernel that fit, because nobody says which are drawn. Only a
  // vertex kernel of the wide tier has storage buffers, so that no pair of the others can fail.
  void checkPairs() {
    for (const Unit& vertex : units_) {
      const uint32_t own = storageBuffers(vertex);
      if (vertex.kernel->stage != Stage::kVertex || own == 0) continue;
      // PK217 and PK218 have said so.
      if (own > limitsOf(vertex.kernel->tierOf(vertex.permutation)).storageBuffers.vertex) continue;
      for (const Unit& pixel : units_) {
        if (!canBeDrawn(vertex, pixel)) continue;
        const Tier tier = std::max(vertex.kernel->tierOf(vertex.permutation),
                                   pixel.kernel->tierOf(pixel.permutation));
        const uint32_t both = own + storageBuffers(pixel);
        if (both <= limitsOf(tier).drawStorageBuffers) continue;
        const SourceLocation where = locate(vertex, vertex.kernel->name);
        result_.diagnostics.error(
            where.file, where.line, "PK702",
            "kernels " + describe(vertex) + " and " + describe(pixel) + " have " +
                std::to_string(both) + " storage buffers together; tier " + tierName(tier) +
                " has " + std::to_string(limitsOf(tier).drawStorageBuffers) +
                " for both stages of a draw: merge some, or put the kernels into groups that do "
                "not share layouts");
      }
    }
  }

  // PK703: what WebGPU has too little of, or not at all.
  void checkWebgpu() {
    if (!result_.program.manifest.webgpu) return;
    for (const Unit& unit : units_) {
      if (unit.kernel->whyNotWebgpu(unit.permutation) != nullptr) continue;
      const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
      if (!module) continue;
      const SourceLocation where = locate(unit, unit.kernel->name);
      const auto error = [&](const std::string& what) {
        result_.diagnostics.error(where.file, where.line, "PK703",
                                  "kernel " + describe(unit) + " " + what +
                                      ": change it, or name the reason in \"noWebgpu\"");
      };
      const auto check = [&](uint64_t count, uint32_t most, const char* what) {
        if (count > most)
          error("has " + std::to_string(count) + " " + what + ", WebGPU promises " +
                std::to_string(most));
      };
      const Stage stage = unit.kernel->stage;
      const ModuleReflection reflection = reflectModule(*module);
      std::map<ResourceKind, uint32_t> counts;
      for (const Resource& resource : reflection.resources) ++counts[resource.kind];
      check(counts[ResourceKind::kStorageBuffer], kWebgpuLimits.storageBuffers.of(stage),
            "storage buffers");
      check(counts[ResourceKind::kUniformBuffer], kWebgpuLimits.uniformBlocks.of(stage),
            "constant blocks");
      check(counts[ResourceKind::kSampledTexture], kWebgpuLimits.textures.of(stage), "textures");
      check(counts[ResourceKind::kStorageTexture], kWebgpuLimits.images.of(stage), "images");
      check(uint64_t{reflection.groupSize[0]} * reflection.groupSize[1] * reflection.groupSize[2],
            kWebgpuLimits.groupThreads, "threads in a group");
      for (size_t axis = 0; axis < 3; ++axis)
        check(reflection.groupSize[axis], kWebgpuLimits.groupSize[axis], "threads on an axis");
      check(reflection.sharedBytes, kWebgpuLimits.groupSharedBytes, "bytes of groupshared memory");
      if (stage != Stage::kPixel) continue;
      for (const auto& [id, access] : resourceAccess(*module)) {
        if (access == Access::kRead) continue;
        error("writes '" + module->name(id) + "', and pixel kernels write no buffers on WebGPU");
        break;
      }
    }
  }

  static std::string describe(const Unit& unit) {
    return "'" + unit.kernel->name + "'" + (unit.key.empty() ? "" : " with " + unit.key);
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
        if (kernel.stage == Stage::kVertex) collectInputs(unit, output);
        const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
        if (!module || unit.back.spirv.empty()) continue;
        const auto [found, added] = known.emplace(unit.back.spirv, output.variants.size());
        if (!added) {
          VariantOutput& same = output.variants[found->second];
          if (kernel.whyNotWebgpu(unit.permutation) == nullptr) same.noWebgpu.clear();
          same.permutations.push_back(unit.permutation);
          same.tier = std::min(same.tier, kernel.tierOf(unit.permutation));
          continue;
        }
        output.variants.push_back(makeVariant(unit, *module, plan));
        origins_[output.variants.back().hash] = &unit;
        if (!options_.wgslTranslator.empty())
          wgslModules_[output.variants.back().hash] = prepareForWgsl(unit.back.spirv);
      }
      std::sort(output.specConstants.begin(), output.specConstants.end(),
                [](const SpecConstantInfo& a, const SpecConstantInfo& b) { return a.id < b.id; });
      result_.distinct += output.variants.size();
      result_.program.kernels.push_back(std::move(output));
    }
  }

  // Translates all variants that run on WebGPU and are not in the cache in one run of Node.js.
  void translateToWgsl() {
    Program& program = result_.program;
    if (options_.wgslTranslator.empty() || !program.manifest.webgpu) return;
    program.wgsl = true;
    const fs::path translator = fs::absolute(options_.wgslTranslator);
    Sha256 tools;
    for (const fs::path& file : {translator, translator.parent_path() / "package-lock.json"})
      tools.field(readWholeFile(file).value_or(""));
    const std::string toolKey = hex(tools.finish());
    struct Job {
      VariantOutput* variant;
      const ManifestKernel* kernel;
      std::string key;
      fs::path stem;
    };
    std::vector<Job> jobs;
    const fs::path folder = scratch_ / "wgsl";
    for (KernelOutput& output : program.kernels) {
      for (VariantOutput& variant : output.variants) {
        if (!variant.noWebgpu.empty()) continue;
        const std::vector<uint32_t>& words = wgslModules_.at(variant.hash);
        Sha256 hash;
        hash.field("wgsl").field(kCacheFormat).field(toolKey).words(words);
        Job job{&variant, &output.kernel, hex(hash.finish()),
                folder / std::to_string(variant.hash)};
        variant.wgsl = cache_.load(job.key).value_or("");
        if (!variant.wgsl.empty()) continue;
        require(writeWholeFile(job.stem.string() + ".spv", toBytes(words)), job.stem);
        jobs.push_back(std::move(job));
      }
    }
    if (jobs.empty()) return;
    const fs::path log = scratch_ / "wgsl.log";
    const ProcessResult ran =
        runProgram({options_.node.string(), translator.string(), folder.string()}, log);
    if (ran.end != ProcessResult::End::kDone) {
      const std::string said = readWholeFile(log).value_or("");
      result_.diagnostics.error(program.manifest.file, 1, "PK411",
                                translator.string() + ": " + ran.reason + " " + said);
      return;
    }
    for (const Job& job : jobs) {
      job.variant->wgsl = readWholeFile(job.stem.string() + ".wgsl").value_or("");
      if (!job.variant->wgsl.empty()) {
        cache_.store(job.key, job.variant->wgsl);
        continue;
      }
      std::string why = readWholeFile(job.stem.string() + ".error").value_or("no output");
      std::replace(why.begin(), why.end(), '\n', ' ');
      result_.diagnostics.error(job.kernel->file, 1, "PK414",
                                "kernel '" + job.kernel->name + "' with '" +
                                    permutationKey(*job.kernel, job.variant->permutations.front()) +
                                    "' cannot be written as WGSL: " + why +
                                    ": change it, or name the reason in \"noWebgpu\"");
    }
  }

  void translateToMsl() {
    Program& program = result_.program;
    program.hlsl = options_.hlsl;
    program.msl = options_.msl;
    if (!options_.msl) return;
    inParallel<KernelOutput>(program.kernels, [this](KernelOutput& output, size_t) {
      uint32_t vertexBuffers = 0;  // Metal's attributes may not reach into the next elements
      if (const auto& input = output.kernel.vertexInput) {
        for (const uint32_t offset : input->offsets)
          vertexBuffers = std::max(vertexBuffers, offset / input->stride + 1);
      }
      for (VariantOutput& variant : output.variants)
        variant.msl = writeMsl(origins_.at(variant.hash)->back.optimised, vertexBuffers);
    });
    for (const KernelOutput& output : program.kernels) {
      for (const VariantOutput& variant : output.variants) {
        const Unit& unit = *origins_.at(variant.hash);
        const SourceLocation where = locate(unit, unit.kernel->name);
        for (const BackEndError& error : variant.msl.errors)
          result_.diagnostics.error(where.file, where.line, error.code,
                                    "kernel " + describe(unit) + " " + error.message);
      }
    }
  }

  static std::string toBytes(const std::vector<uint32_t>& words) {
    std::string bytes;
    bytes.reserve(words.size() * sizeof(uint32_t));
    for (const uint32_t word : words) {
      for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(word >> shift & 0xffu);
    }
    return bytes;
  }

  // Puts the variants' code together, format by format, and compresses it.
  void packKernels() {
    inParallel<KernelOutput>(result_.program.kernels, [this](KernelOutput& output, size_t) {
      for (const CodeFormat format :
           {CodeFormat::kSpirv, CodeFormat::kGlsl, CodeFormat::kEssl, CodeFormat::kWgsl}) {
        PackedCode& code = output.code[static_cast<size_t>(format)];
        std::string all;
        for (const VariantOutput& variant : output.variants) {
          const std::string own = codeOf(variant, format);
          if (own.empty()) continue;
          code.ranges.push_back(
              {variant.hash, static_cast<uint32_t>(all.size()), static_cast<uint32_t>(own.size())});
          all += own;
        }
        if (all.empty()) continue;
        code.unpackedBytes = static_cast<uint32_t>(all.size());
        const std::string key = hex(
            Sha256().field("pack").field(kCacheFormat).field(packVersion()).field(all).finish());
        code.bytes = cache_.load(key).value_or("");
        if (!code.bytes.empty()) continue;
        code.bytes = pack(all);
        cache_.store(key, code.bytes);
      }
    });
    for (const KernelOutput& output : result_.program.kernels) {
      for (const PackedCode& code : output.code) {
        if (code.bytes.empty() && !code.ranges.empty())
          result_.diagnostics.error(output.kernel.file, 1, "PK413",
                                    "no memory to compress the code");
      }
    }
  }

  // The bytes of a variant's code.
  std::string codeOf(const VariantOutput& variant, CodeFormat format) const {
    if (format != CodeFormat::kSpirv) {
      const std::string& source = format == CodeFormat::kGlsl   ? variant.glsl
                                  : format == CodeFormat::kEssl ? variant.essl
                                                                : variant.wgsl;
      return options_.keepNames ? source : withoutIndentation(source);
    }
    return toBytes(variant.spirv);
  }

  static std::string withoutIndentation(std::string_view source) {
    std::string text;
    text.reserve(source.size());
    bool lineStart = true;
    for (const char c : source) {
      if (lineStart && c == ' ') continue;
      lineStart = c == '\n';
      text += c;
    }
    return text;
  }

  VariantOutput makeVariant(const Unit& unit, const SpirvReader& module, LayoutPlan& plan) const {
    VariantOutput variant;
    variant.permutations.push_back(unit.permutation);
    variant.spirv = options_.keepNames ? unit.back.optimised : unit.back.spirv;
    variant.glsl = unit.back.glsl;
    variant.essl = unit.back.essl;
    // Two manifests may have one kernel, with the same SPIR-V and other numbers in its GLSL.
    Sha256 hash;
    hash.words(unit.back.spirv);
    const uint32_t firstBinding = firstStorageBinding(unit);
    if (firstBinding != 0) hash.field(uint64_t{firstBinding});
    variant.hash = shortHash(hash.finish());
    const ModuleReflection reflection = reflectModule(module);
    std::copy_n(reflection.groupSize, 3, variant.groupSize);
    variant.sharedBytes = reflection.sharedBytes;
    variant.tier = unit.kernel->tierOf(unit.permutation);
    if (const std::string* why = unit.kernel->whyNotWebgpu(unit.permutation))
      variant.noWebgpu = *why;
    for (const Resource& resource : unit.reflection.resources)
      variant.registers.push_back(
          {resource.name, resource.registerClass, resource.registerNumber, resource.space});
    const auto numbers = storageBufferNumbers(module, firstBinding);
    for (const auto& [id, access] : resourceAccess(module)) {
      const uint32_t set = module.decoration(id, SpvDecorationDescriptorSet).value_or(0);
      const uint32_t binding = module.decoration(id, SpvDecorationBinding).value_or(0);
      std::vector<PlannedEntry>& entries = plan.layout(unit.kernel->group, set).entries;
      if (binding >= entries.size()) continue;
      entries[binding].access = entries[binding].access | access;
      const auto number = numbers.find({set, binding});
      variant.bindings.push_back(
          {set, binding, access,
           number != numbers.end() ? number->second : entries[binding].glBinding});
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

  // The vertex stage's inputs, one for each offset of the manifest and the same in all
  // permutations.
  void collectInputs(const Unit& unit, KernelOutput& output) {
    const ManifestKernel& kernel = *unit.kernel;
    const std::vector<StageInput>& inputs = unit.reflection.inputs;
    const SourceLocation where = locate(unit, kernel.name);
    const size_t known = kernel.vertexInput ? kernel.vertexInput->offsets.size() : 0;
    const auto error = [&](const std::string& message) {
      result_.diagnostics.error(where.file, where.line, "PK513",
                                "kernel '" + kernel.name + "' " + message);
    };
    bool fits = inputs.size() == known;
    for (size_t i = 0; i < inputs.size(); ++i) {
      fits = fits && inputs[i].location == i;
      if (inputs[i].scalar != ScalarType::kFloat && inputs[i].scalar != ScalarType::kUint)
        error("has an input '" + inputs[i].name +
              "' that is no float or uint, or a vector of them");
    }
    if (!fits) {
      error("has " + std::to_string(inputs.size()) +
            " vertex inputs, but \"vertexInput\" in the "
            "manifest has " +
            std::to_string(known) + " offsets: locations from 0 on, an offset each");
    } else if (output.variants.empty() && output.inputs.empty()) {
      output.inputs = inputs;
    } else if (output.inputs != inputs) {
      error("has other vertex inputs in other permutations");
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
    for (auto& [name, text] : emitSources(result_.program))
      files[options_.outputDir / name] = std::move(text);
    for (auto& [name, text] : emitCode(result_.program))
      files[options_.outputDir / name] = std::move(text);
    if (result_.program.msl) {
      for (auto& [name, text] : emitMetal(result_.program))
        files[options_.outputDir / name] = std::move(text);
    }
    if (result_.program.hlsl)
      files[options_.outputDir / "dxc.txt"] = emitDxcLines(result_.program, options_.includeDirs);
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
  std::deque<Worker> workers_;
  std::map<std::string, std::vector<std::string>> closures_;  // by kernel or file
  std::vector<Unit> units_;
  std::map<uint64_t, std::vector<uint32_t>> wgslModules_;  // by VariantOutput::hash
  std::map<uint64_t, const Unit*> origins_;                // by VariantOutput::hash
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
