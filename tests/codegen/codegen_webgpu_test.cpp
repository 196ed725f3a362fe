// Codegen keeps kernels to the limits of WebGPU. Dawn reads them in tests/webgpu.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "codegen/reflect.h"
#include "codegen/spirv_reader.h"
#include "codegen/wgsl_module.h"
#include "pelage/kernel_code.h"
#include "pelage/kernels.h"
#include "pelage/spirv.h"
#include "test_project.h"

namespace pelage::codegen::test {
namespace {

std::string onWebgpu(const std::string& kernels) {
  std::string manifest = manifestWith(kernels);
  return manifest.insert(manifest.find('{') + 1, "\n  \"webgpu\": true,");
}

// A compute kernel with these storage buffers, threads and words of shared memory.
std::string kernelWith(uint32_t buffers, uint32_t threads, uint32_t sharedWords) {
  std::string text, sum = "0u";
  for (uint32_t b = 0; b < buffers; ++b) {
    const std::string n = std::to_string(b);
    text += "RWStructuredBuffer<uint> g_b" + n + " : register(u" + n + ", space0);\n";
    sum += " + g_b" + n + "[i]";
  }
  return text + "groupshared uint s_words[" + std::to_string(sharedWords) + "];\n[numthreads(" +
         std::to_string(threads) + ", 1, 1)]\nvoid some(uint i : SV_GroupIndex) {\n  s_words[i % " +
         std::to_string(sharedWords) + "u] = " + sum +
         ";\n  GroupMemoryBarrierWithGroupSync();\n  g_b0[i] = s_words[0];\n}\n";
}

std::string messagesOf(const std::string& kernel, const std::string& more) {
  const TestProject project;
  project.write("manifest.json", onWebgpu(computeKernel("some", ", \"tier\": \"wide\"" + more)));
  project.write("some.hlsl", kernel);
  return project.build().diagnostics.format();
}

TEST(CodegenWebgpu, RefusesWhatWebgpuHasTooLittleOf) {
  EXPECT_EQ(messagesOf(kernelWith(8, 256, 4096), ""), "");
  const auto refuses = [](const std::string& kernel, const char* message) {
    const std::string messages = messagesOf(kernel, "");
    EXPECT_NE(messages.find("[PK703]"), std::string::npos) << messages;
    EXPECT_NE(messages.find(message), std::string::npos) << messages;
    EXPECT_EQ(messagesOf(kernel, R"(, "noWebgpu": [{"why": "a test"}])"), "");
  };
  refuses(kernelWith(9, 256, 4096), "'some' has 9 storage buffers, WebGPU promises 8");
  refuses(kernelWith(8, 257, 4096), "'some' has 257 threads in a group, WebGPU promises 256");
  refuses(kernelWith(8, 256, 4097),
          "'some' has 16388 bytes of groupshared memory, WebGPU promises 16384");
}

TEST(CodegenWebgpu, RefusesPixelKernelsThatWriteBuffers) {
  const TestProject project;
  const auto build = [&](const char* more) {
    project.write("manifest.json",
                  onWebgpu(std::string(R"(    {"name": "paint", "file": "paint.hlsl",
      "stage": "pixel", "group": "g", "axes": [{"name": "keep"}])") +
                           more + "}"));
    project.write("paint.hlsl",
                  "RWStructuredBuffer<uint> g_kept : register(u0, space0);\n"
                  "float4 paint(float4 at : SV_Position) : SV_Target {\n#if KEEP\n"
                  "  g_kept[uint(at.x)] = 1u;\n#endif\n"
                  "  return float4(at.xy, g_kept[0], 1.0);\n}\n");
    return project.build().diagnostics.format();
  };
  const std::string messages = build("");
  EXPECT_NE(messages.find("paint.hlsl:2: error: [PK703] kernel 'paint' with keep=1 writes "
                          "'g_kept', and pixel kernels write no buffers on WebGPU"),
            std::string::npos)
      << messages;
  EXPECT_EQ(build(R"(, "noWebgpu": [{"when": {"keep": true}, "why": "a test"}])"), "");
  EXPECT_NE(build(R"(, "noWebgpu": [{"when": {"keep": false}, "why": "a test"}])"), "");
  EXPECT_NE(build(R"(, "noWebgpu": [{"when": {"keep": true}}])").find("\"why\""),
            std::string::npos);
}

// Access chains that are used outside of the block that has them.
uint32_t farChains(const SpirvReader& module) {
  std::map<uint32_t, uint32_t> blocks;
  uint32_t block = 0, count = 0;
  for (const SpirvInstruction& instruction : module.instructions()) {
    if (instruction.op == SpvOpLabel) block = instruction.result;
    if (instruction.op == SpvOpPhi) continue;  // operands of other blocks, and never chains
    const bool hasPointer = instruction.op == SpvOpStore || instruction.op == SpvOpLoad ||
                            instruction.op == SpvOpAccessChain ||
                            (instruction.op >= SpvOpAtomicLoad && instruction.op <= SpvOpAtomicXor);
    if (hasPointer) {
      const auto chain = blocks.find(instruction.operands[0]);
      if (chain != blocks.end() && chain->second != block) ++count;
    }
    if (instruction.op == SpvOpAccessChain) blocks[instruction.result] = block;
  }
  return count;
}

// Values of atomic operations that come from another block.
uint32_t farValues(const SpirvReader& module) {
  std::map<uint32_t, uint32_t> blocks;
  uint32_t block = 0, count = 0;
  for (const SpirvInstruction& instruction : module.instructions()) {
    if (instruction.op == SpvOpLabel) block = instruction.result;
    if (instruction.op >= SpvOpAtomicIAdd && instruction.op <= SpvOpAtomicXor) {
      const auto value = blocks.find(instruction.operands.back());
      if (value != blocks.end() && value->second != block) ++count;
    }
    if (block != 0) blocks[instruction.result] = block;
  }
  return count;
}

TEST(CodegenWebgpu, PutsPointersAndAtomicValuesIntoTheBlockThatUsesThem) {
  const KernelCodes codes(allSpirv());
  uint32_t before = 0, valuesBefore = 0;
  for (const Kernel* kernel : allKernels()) {
    for (const KernelVariant* variant : kernel->variants) {
      const std::vector<uint32_t> words = *codes.spirv(*variant);
      const auto module = SpirvReader::parse(words);
      ASSERT_TRUE(module) << kernel->name;
      const std::vector<uint32_t> prepared = prepareForWgsl(words);
      const auto after = SpirvReader::parse(prepared);
      ASSERT_TRUE(after) << kernel->name;
      before += farChains(*module);
      EXPECT_EQ(farChains(*after), 0u) << kernel->name << ' ' << variant->key;
      valuesBefore += farValues(*module);
      EXPECT_EQ(farValues(*after), 0u) << kernel->name << ' ' << variant->key;
      // The buffers that it only reads are those that may not be written.
      for (const auto& [id, access] : resourceAccess(*after)) {
        if (after->definition(id)->operands[0] != SpvStorageClassStorageBuffer) continue;
        EXPECT_EQ(after->decoration(id, SpvDecorationNonWritable).has_value(),
                  access == Access::kRead)
            << kernel->name;
      }
    }
  }
  EXPECT_GT(before, 0u);
  EXPECT_GT(valuesBefore, 0u);
}

TEST(CodegenWebgpu, PageListsEveryKernelThatDoesNotRunThere) {
  const auto reflection = nlohmann::json::parse(fileText(PELAGE_KERNELS_REFLECTION));
  std::string table;
  for (const auto& kernel : reflection["kernels"]) {
    const auto& variants = kernel["variants"];
    const auto runsNot = [](const auto& variant) { return variant.contains("noWebgpu"); };
    const bool none = std::all_of(variants.begin(), variants.end(), runsNot);
    for (const auto& variant : variants) {
      if (!runsNot(variant)) continue;
      std::string row = "| `" + std::string(kernel["name"]) + "`";
      if (!none) row += " with `" + std::string(variant["keys"][0]) + "`";
      row += " | " + std::string(variant["noWebgpu"]) + " |\n";
      if (table.find(row) == std::string::npos) table += row;
    }
  }
  EXPECT_NE(table, "");
  const std::string page = fileText(PELAGE_CODEGEN_TEST_DIR "/../../docs/webgpu.md");
  const std::string head = "| kernel | why |\n|---|---|\n";
  const size_t begin = page.find(head);
  ASSERT_NE(begin, std::string::npos);
  const size_t end = page.find("\n\n", begin);
  EXPECT_EQ(page.substr(begin + head.size(), end + 1 - begin - head.size()), table);
}

}  // namespace
}  // namespace pelage::codegen::test
