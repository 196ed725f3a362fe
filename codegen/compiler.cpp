#include "codegen/compiler.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include "codegen/device_limits.h"
#include "codegen/driver.h"
#include "codegen/file_io.h"
#include "codegen/parallel.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

// All that was read must be known to the dependency scan.
void checkIncludes(const std::string& source, const std::vector<std::string>& read,
                   const std::vector<std::string>& closure, const fs::path& baseDir,
                   Diagnostics& diagnostics) {
  for (const std::string& file : read) {
    const std::string name = displayName(baseDir / file, baseDir);
    if (std::find(closure.begin(), closure.end(), name) != closure.end()) continue;
    diagnostics.error(source, 1, "PK409",
                      "'" + file +
                          "' is included through a macro: write the name in the #include line, so "
                          "that a change of the file is noticed");
  }
}

// Why there is no complete result.
std::string failure(const std::string& step, const std::string& subject,
                    const ProcessResult& process, const fs::path& log) {
  using End = ProcessResult::End;
  const char* what = process.end == End::kTimedOut  ? "did not finish"
                     : process.end == End::kCrashed ? "crashed on"
                                                    : "failed on";
  const std::string said = readWholeFile(log).value_or("");
  return fmt::format("the {} {} {}: {}", step, what, subject, process.reason) +
         (said.empty() ? "" : "; it said: " + said.substr(0, said.find('\n')));
}

}  // namespace

template <class Result>
struct Compiler::Job {
  std::string step, subject;  // for messages
  SourceLocation where;       // of messages
  std::string name;           // of the child's files
  std::string key;            // in the cache
  std::string encoded;
  std::optional<Result> (*decode)(const std::string&);
  std::vector<std::string> closure;  // what the child may read
};

Compiler::Compiler(const BuildOptions& options, FrontEndInput source, fs::path scratch,
                   std::string toolHash, const Cache& cache, IncludeScanner& scanner)
    : source_(std::move(source)),
      scratch_(std::move(scratch)),
      toolHash_(std::move(toolHash)),
      timeout_(options.timeout),
      cache_(cache),
      scanner_(scanner) {
  const unsigned jobs = options.jobs != 0 ? options.jobs : std::thread::hardware_concurrency();
  for (unsigned i = 0; i < std::max(jobs, 1u); ++i) workers_.emplace_back(options.tool);
}

Sha256 Compiler::startKey(const std::string& step) const {
  Sha256 key;
  key.field(step).field(kCacheFormat).field(toolHash_);
  key.field(frontEndVersion()).field(backEndVersion());
  return key;
}

template <class Result>
bool Compiler::run(const Job<Result>& job, Worker& worker, Result& result) const {
  if (const std::optional<std::string> cached = cache_.load(job.key)) {
    if (std::optional<Result> known = job.decode(*cached)) {
      result = std::move(*known);
      return false;
    }
  }
  const std::string stem = (scratch_ / (job.name + "-" + job.step)).string();
  ProcessResult process;
  if (writeWholeFile(stem + ".job", job.encoded)) {
    process = worker.run(stem, timeout_);
  } else {
    process.reason = "cannot write " + stem + ".job";
  }
  // A child that crashed leaves what it found before: an error among it explains the crash better.
  if (const std::optional<std::string> text = readWholeFile(stem + ".result"))
    result = job.decode(*text).value_or(Result());
  const bool done = process.end == ProcessResult::End::kDone && result.complete;
  if (!done && !result.diagnostics.hasErrors()) {
    result.diagnostics.error(job.where, "PK411",
                             failure(job.step, job.subject, process, stem + ".log"));
  }
  if constexpr (requires { result.files; })
    checkIncludes(job.where.file, result.files, job.closure, source_.baseDir, result.diagnostics);
  if (!result.diagnostics.hasErrors()) cache_.store(job.key, encode(result));
  return true;
}

ConstantsResult Compiler::constants(const ManifestConstants& listed) {
  const std::vector<std::string> closure = scanner_.closure(listed.file);
  Sha256 key = startKey("constants");
  key.field(listed.file);
  for (const std::string& name : closure) key.field(name).field(scanner_.contentHash(name));
  ConstantsJob job{source_};
  job.source.file = listed.file;
  ConstantsResult result;
  run<ConstantsResult>(
      {"evaluation of constants", "file '" + listed.file + "'", SourceLocation{listed.file, 1},
       listed.space, hex(key.finish()), encode(job), &decodeConstantsResult, closure},
      workers_[0], result);
  return result;
}

void Compiler::frontEnd(std::vector<Unit>& units) {
  for (const Unit& unit : units) scanner_.closure(unit.kernel->file);  // reads for all threads
  inParallel(units, threads(), [&](Unit& unit, size_t thread) {
    frontEnd(unit, std::to_string(&unit - units.data()), workers_[thread]);
    if (const std::optional<SpirvReader> module = SpirvReader::parse(unit.front.spirv))
      unit.reflection = reflectModule(*module);
  });
}

void Compiler::frontEnd(Unit& unit, const std::string& name, Worker& worker) {
  const ManifestKernel& kernel = *unit.kernel;
  FrontEndJob job{source_, kernel.precise};
  job.source.file = kernel.file;
  job.source.entry = kernel.name;
  job.source.stage = kernel.stage;
  for (size_t i = 0; i < kernel.axes.size(); ++i) {
    job.source.macros.emplace_back(macroName(kernel.axes[i].name),
                                   std::to_string(unit.permutation[i]));
  }
  const std::vector<std::string> closure = scanner_.closure(kernel.file);
  Sha256 key = startKey("front end");
  key.field(kernel.file).field(kernel.name).field(static_cast<uint64_t>(kernel.stage));
  key.field(uint64_t{kernel.precise}).field(uint64_t{job.source.macros.size()});
  for (const auto& [macro, value] : job.source.macros) key.field(macro).field(value);
  for (const std::string& file : closure) key.field(file).field(scanner_.contentHash(file));
  unit.ran |= run<FrontEndResult>(
      {"front end", "kernel '" + kernel.name + "'", SourceLocation{kernel.file, 1}, name,
       hex(key.finish()), encode(job), &decodeFrontEndResult, closure},
      worker, unit.front);
}

void Compiler::backEnd(std::vector<Unit>& units, const LayoutPlan& plan, const Manifest& manifest) {
  // The numbers of vertex kernels' buffers follow those of the pixel kernels.
  for (const bool vertex : {false, true}) {
    inParallel(units, threads(), [&](Unit& unit, size_t thread) {
      const ManifestKernel& kernel = *unit.kernel;
      if (!unit.reflection || (kernel.stage == Stage::kVertex) != vertex) return;
      unit.firstStorageBinding = firstStorageBinding(unit, units, manifest);
      const SourceLocation where = unit.locate(kernel.name);
      const std::string encoded = encode(BackEndJob{kernel.file, kernel.name, where, kernel.stage,
                                                    kernel.tierOf(unit.permutation), kernel.precise,
                                                    unit.firstStorageBinding, unit.front.spirv,
                                                    unit.front.log, plan.patches(unit)});
      unit.ran |= run<BackEndResult>({"back end",
                                      "kernel '" + kernel.name + "'",
                                      where,
                                      std::to_string(&unit - units.data()),
                                      hex(startKey("back end").field(encoded).finish()),
                                      encoded,
                                      &decodeBackEndResult,
                                      {}},
                                     workers_[thread], unit.back);
      if (const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised))
        unit.storageBuffers = static_cast<uint32_t>(storageBufferNumbers(*module, 0).size());
    });
  }
}

void Compiler::finish(const std::string& file, Diagnostics& diagnostics) {
  for (Worker& worker : workers_) {
    const ProcessResult process = worker.finish();
    if (process.end == ProcessResult::End::kDone) continue;
    diagnostics.error(file, 1, "PK411", "a compiler crashed at its end: " + process.reason);
  }
}

}  // namespace pelage::codegen
