// Kernels for Metal and Direct3D 12: tables and MSL for the one, command lines for the other.
#include <fmt/format.h>

#include "codegen/enum_names.h"
#include "codegen/program.h"

namespace pelage::codegen {
namespace {

std::string stem(const KernelOutput& kernel, const VariantOutput& variant) {
  return fmt::format("{}_{:016x}", kernel.kernel.name, variant.hash);
}

std::string slotText(uint8_t slot) {
  return slot == MetalKernel::kNone ? "MetalKernel::kNone" : std::to_string(slot);
}

}  // namespace

std::string mslFile(const KernelOutput& kernel, const VariantOutput& variant) {
  return stem(kernel, variant) + ".metal";
}

std::vector<std::string> hlslDefines(const KernelOutput& kernel, const VariantOutput& variant) {
  std::vector<std::string> defines;
  for (size_t i = 0; i < kernel.kernel.axes.size(); ++i)
    defines.push_back(fmt::format("{}={}", macroName(kernel.kernel.axes[i].name),
                                  variant.permutations.front()[i]));
  return defines;
}

std::string hlslProfile(Stage stage) {
  return stage == Stage::kCompute ? "cs_6_0" : stage == Stage::kVertex ? "vs_6_0" : "ps_6_0";
}

std::map<std::string, std::string> emitMetal(const Program& program) {
  constexpr const char* kTables[] = {"kBuffer", "kTexture", "kSampler"};
  std::map<std::string, std::string> files;
  std::string bindings, kernels;
  size_t count = 0, kernelCount = 0;
  for (const KernelOutput& kernel : program.kernels) {
    for (const VariantOutput& variant : kernel.variants) {
      const MslModule& msl = variant.msl;
      files["msl/" + mslFile(kernel, variant)] = msl.source;
      for (const MetalBinding& b : msl.bindings)
        bindings += fmt::format("    {{{}, {}, MetalTable::{}, {}, {}}},\n", b.set, b.entry,
                                kTables[static_cast<size_t>(b.table)], b.slot, b.bytes);
      kernels += fmt::format(
          "    // {}\n    {{0x{:016x}ull, \"{}\", \"{}\",\n"
          "     std::span(kMetalBindings).subspan({}, {}), {}, {}, {{{}, {}, {}}}, {}}},\n",
          permutationKey(kernel.kernel, variant.permutations.front()), variant.hash,
          mslFile(kernel, variant), msl.function, count, msl.bindings.size(),
          slotText(msl.vertexBuffer), slotText(msl.sizes), variant.groupSize[0],
          variant.groupSize[1], variant.groupSize[2], variant.sharedBytes);
      count += msl.bindings.size();
      ++kernelCount;
    }
  }
  std::string text = generatedHead(program, "Slots of the kernels on Metal. Compiled, never run.");
  text += fmt::format(
      "#pragma once\n\n#include <array>\n\n#include \"pelage/metal_kernel.h\"\n\nnamespace {} "
      "{{\n\n"
      "using ::pelage::MetalBinding, ::pelage::MetalKernel, ::pelage::MetalTable;\n\n"
      "/// Slots of all permutations, one permutation behind the other.\n"
      "inline constexpr std::array<MetalBinding, {}> kMetalBindings = {{{{\n{}}}}};\n\n"
      "/// All permutations, in the order of the manifest.\n"
      "inline constexpr std::array<MetalKernel, {}> kMetalKernels = {{{{\n{}}}}};\n\n"
      "}}  // namespace {}\n",
      program.manifest.namespaceName(), count, bindings, kernelCount, kernels,
      program.manifest.namespaceName());
  files["include/" + program.manifest.namespaceFolder() + "/metal.h"] = std::move(text);
  return files;
}

std::string emitDxcLines(const Program& program,
                         const std::vector<std::filesystem::path>& includeDirs) {
  std::string text, includes = " -I .";
  for (const std::filesystem::path& dir : includeDirs)
    includes += " -I " + std::filesystem::absolute(dir).lexically_normal().generic_string();
  for (const KernelOutput& kernel : program.kernels) {
    for (const VariantOutput& variant : kernel.variants) {
      // Before HLSL 2021, `&&` evaluates both sides, as the kernels expect.
      text +=
          fmt::format("-T {} -E {} -HV 2018", hlslProfile(kernel.kernel.stage), kernel.kernel.name);
      if (kernel.kernel.precise) text += " -Gis";
      for (const std::string& define : hlslDefines(kernel, variant)) text += " -D " + define;
      text +=
          fmt::format("{} -Fo {}.dxil {}\n", includes, stem(kernel, variant), kernel.kernel.file);
    }
  }
  return text;
}

}  // namespace pelage::codegen
