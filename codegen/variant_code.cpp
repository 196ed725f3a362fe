#include "codegen/variant_code.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "codegen/driver.h"
#include "codegen/file_io.h"
#include "codegen/hash.h"
#include "codegen/pack.h"
#include "codegen/parallel.h"
#include "codegen/process.h"
#include "codegen/wgsl_module.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

// The first permutation of a variant.
const Unit& unitOf(const KernelOutput& output, const VariantOutput& variant,
                   const std::vector<Unit>& units) {
  return *std::find_if(units.begin(), units.end(), [&](const Unit& unit) {
    return unit.kernel->name == output.kernel.name &&
           unit.permutation == variant.permutations.front();
  });
}

std::string toBytes(const std::vector<uint32_t>& words) {
  std::string bytes;
  bytes.reserve(words.size() * sizeof(uint32_t));
  for (const uint32_t word : words) {
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(word >> shift & 0xffu);
  }
  return bytes;
}

std::string withoutIndentation(std::string_view source) {
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

// The bytes of a variant's code.
std::string codeOf(const VariantOutput& variant, CodeFormat format, bool indent) {
  if (format == CodeFormat::kSpirv) return toBytes(variant.spirv);
  const std::string& source = format == CodeFormat::kGlsl   ? variant.glsl
                              : format == CodeFormat::kEssl ? variant.essl
                                                            : variant.wgsl;
  return indent ? source : withoutIndentation(source);
}

}  // namespace

void translateToWgsl(const BuildOptions& options, const fs::path& folder, const Cache& cache,
                     const std::vector<Unit>& units, Program& program, Diagnostics& diagnostics) {
  const fs::path translator = fs::absolute(options.wgslTranslator);
  Sha256 tools;
  for (const char* file : {"translate.mjs", "uniform.mjs", "package-lock.json"})
    tools.field(readWholeFile(translator.parent_path() / file).value_or(""));
  const std::string toolKey = hex(tools.finish());
  struct Job {
    VariantOutput* variant;
    const Unit* unit;
    std::string key, stem;
  };
  std::vector<Job> jobs;
  for (KernelOutput& output : program.kernels) {
    for (VariantOutput& variant : output.variants) {
      if (!variant.noWebgpu.empty()) continue;
      const Unit& unit = unitOf(output, variant, units);
      const std::vector<uint32_t> words = prepareForWgsl(unit.back.spirv);
      Sha256 key;
      key.field("wgsl").field(kCacheFormat).field(toolKey).words(words);
      Job job{&variant, &unit, hex(key.finish()), folder / std::to_string(variant.hash)};
      variant.wgsl = cache.load(job.key).value_or("");
      if (!variant.wgsl.empty()) continue;
      if (!writeWholeFile(job.stem + ".spv", toBytes(words)))
        diagnostics.error(program.manifest.file, 1, "PK412", "cannot write " + job.stem);
      jobs.push_back(std::move(job));
    }
  }
  if (jobs.empty()) return;
  const fs::path log = folder.string() + ".log";
  const ProcessResult ran =
      runProgram({options.node.string(), translator.string(), folder.string()}, log);
  if (ran.end != ProcessResult::End::kDone) {
    diagnostics.error(
        program.manifest.file, 1, "PK411",
        fmt::format("{}: {} {}", translator.string(), ran.reason, readWholeFile(log).value_or("")));
    return;
  }
  for (const Job& job : jobs) {
    job.variant->wgsl = readWholeFile(job.stem + ".wgsl").value_or("");
    if (!job.variant->wgsl.empty()) {
      cache.store(job.key, job.variant->wgsl);
      continue;
    }
    std::string why = readWholeFile(job.stem + ".error").value_or("no output");
    std::replace(why.begin(), why.end(), '\n', ' ');
    diagnostics.error(job.unit->kernel->file, 1, "PK414",
                      fmt::format("kernel '{}' with '{}' cannot be written as WGSL: {}: change it, "
                                  "or name the reason in \"noWebgpu\"",
                                  job.unit->kernel->name, job.unit->key, why));
  }
}

void translateToMsl(size_t threads, const std::vector<Unit>& units,
                    std::vector<KernelOutput>& kernels, Diagnostics& diagnostics) {
  inParallel(kernels, threads, [&](KernelOutput& output, size_t) {
    uint32_t vertexBuffers = 0;  // Metal's attributes may not reach into the next elements
    if (const auto& input = output.kernel.vertexInput) {
      for (const uint32_t offset : input->offsets)
        vertexBuffers = std::max(vertexBuffers, offset / input->stride + 1);
    }
    for (VariantOutput& variant : output.variants)
      variant.msl = writeMsl(unitOf(output, variant, units).back.optimised, vertexBuffers);
  });
  for (const KernelOutput& output : kernels) {
    for (const VariantOutput& variant : output.variants) {
      const Unit& unit = unitOf(output, variant, units);
      for (const BackEndError& error : variant.msl.errors)
        diagnostics.error(unit.locate(unit.kernel->name), error.code,
                          "kernel " + unit.text() + " " + error.message);
    }
  }
}

void packKernels(size_t threads, bool indent, const Cache& cache,
                 std::vector<KernelOutput>& kernels, Diagnostics& diagnostics) {
  inParallel(kernels, threads, [&](KernelOutput& output, size_t) {
    for (const CodeFormat format :
         {CodeFormat::kSpirv, CodeFormat::kGlsl, CodeFormat::kEssl, CodeFormat::kWgsl}) {
      PackedCode& code = output.code[static_cast<size_t>(format)];
      std::string all;
      for (const VariantOutput& variant : output.variants) {
        const std::string own = codeOf(variant, format, indent);
        if (own.empty()) continue;
        code.ranges.push_back(
            {variant.hash, static_cast<uint32_t>(all.size()), static_cast<uint32_t>(own.size())});
        all += own;
      }
      if (all.empty()) continue;
      code.unpackedBytes = static_cast<uint32_t>(all.size());
      const std::string key =
          hex(Sha256().field("pack").field(kCacheFormat).field(packVersion()).field(all).finish());
      code.bytes = cache.load(key).value_or("");
      if (!code.bytes.empty()) continue;
      code.bytes = pack(all);
      cache.store(key, code.bytes);
    }
  });
  for (const KernelOutput& output : kernels) {
    for (const PackedCode& code : output.code) {
      if (code.bytes.empty() && !code.ranges.empty())
        diagnostics.error(output.kernel.file, 1, "PK413", "no memory to compress the code");
    }
  }
}

}  // namespace pelage::codegen
