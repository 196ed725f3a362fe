// The code of kernels: every permutation unpacks to its original bytes, and damage is found.
#include "pelage/kernel_code.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "pelage/code.h"
#include "pelage/essl.h"
#include "pelage/glsl.h"
#include "pelage/kernels.h"
#include "pelage/spirv.h"
#include "support/errors.h"
#include "support/test_code.h"
#include "support/test_folder.h"
#ifdef PELAGE_WGSL_DIR
#include "pelage/wgsl.h"
#endif

namespace pelage::test {
namespace {

constexpr uint32_t kSpirvMagic = 0x07230203u;

const KernelVariant& somePermutation() { return shiftPositionsVariant({}); }

TEST(KernelCodes, HaveEveryPermutationInEveryFormat) {
  const KernelCodes codes(allCode());
  for (const Kernel* kernel : allKernels()) {
    for (const KernelVariant* variant : kernel->variants) {
      const auto spirv = required(codes.spirv(*variant));
      ASSERT_GT(spirv->size(), 5u);
      EXPECT_EQ((*spirv)[0], kSpirvMagic) << kernel->name;
      for (const CodeFormat format : {CodeFormat::kGlsl, CodeFormat::kEssl}) {
        const auto source = required(codes.source(*variant, format));
        EXPECT_TRUE(source->starts_with(format == CodeFormat::kGlsl ? "#version 450\n"
                                                                    : "#version 320 es\n"))
            << kernel->name;
        EXPECT_NE(source->find("void main()"), std::string::npos) << kernel->name;
        EXPECT_EQ(source->find('\0'), std::string::npos) << kernel->name;
        // Compilers of GLSL take it for a loop to unroll.
        EXPECT_EQ(source->find("while(false)"), std::string::npos) << kernel->name;
      }
    }
  }
}

#ifdef PELAGE_WGSL_DIR
TEST(KernelCodes, HaveTheWgslThatOtherLanguagesReadInFiles) {
  const KernelCodes codes(allWgsl());
  size_t found = 0;
  for (const Kernel* kernel : allKernels()) {
    for (const KernelVariant* variant : kernel->variants) {
      const auto path = std::filesystem::path(PELAGE_WGSL_DIR) /
                        fmt::format("{}_{:016x}.wgsl", kernel->name, variant->hash);
      const auto source = codes.source(*variant, CodeFormat::kWgsl);
      ASSERT_EQ(source.ok(), std::filesystem::exists(path)) << path;
      if (!source) continue;
      // Without indentation where the build keeps no names.
      EXPECT_NE(source->find(fmt::format("\nfn {}(", kernel->name)), std::string::npos) << path;
      EXPECT_LE(source->size(), std::filesystem::file_size(path)) << path;
      ++found;
    }
  }
  EXPECT_GT(found, 100u);
}
#endif

TEST(KernelCodes, HaveOnlyTheTablesThatTheyWereGiven) {
  const KernelCode* const one[] = {&kShiftPositionsSpirv};
  const KernelCodes codes(one);
  EXPECT_TRUE(codes.spirv(somePermutation()));
  const auto otherFormat = codes.source(somePermutation(), CodeFormat::kGlsl);
  ASSERT_FALSE(otherFormat);
  EXPECT_EQ(otherFormat.error().code, ErrorCode::kUnsupported);
  expectError(codes.spirv(skinRootsVariant()), {"SPIR-V", "skin_roots", "kernel_code.h"});
}

TEST(KernelCodes, TakeTablesTwice) {
  KernelCodes codes(allSpirv());
  const auto before = codes.spirv(somePermutation());
  codes.add(allSpirv());
  const auto after = codes.spirv(somePermutation());
  ASSERT_TRUE(before && after);
  EXPECT_EQ(*before, *after);
}

TEST(KernelCodes, SayWhenATableIsDamaged) {
  const KernelCode& good = kShiftPositionsSpirv;
  const std::string bytes(static_cast<const char*>(good.packed), good.packedBytes);
  const auto errorOf = [&](const KernelCode& code) {
    const KernelCode* const one[] = {&code};
    const auto spirv = KernelCodes(one).spirv(somePermutation());
    EXPECT_FALSE(spirv);
    if (spirv) return std::string();
    EXPECT_EQ(spirv.error().code, ErrorCode::kInvalidFile);
    expectHas(spirv.error().message, "shift_positions");
    return spirv.error().message;
  };
  // Any byte: the frame has a check sum.
  for (size_t i = 0; i < bytes.size(); i += 7) {
    std::string flipped = bytes;
    flipped[i] = static_cast<char>(flipped[i] ^ 0x10);
    KernelCode code = good;
    code.packed = flipped.data();
    const KernelCode* const one[] = {&code};
    const auto spirv = KernelCodes(one).spirv(somePermutation());
    const auto whole = KernelCodes(allSpirv()).spirv(somePermutation());
    if (spirv) {
      EXPECT_EQ(*spirv, *whole) << "byte " << i;
    } else {
      EXPECT_EQ(spirv.error().code, ErrorCode::kInvalidFile);
    }
  }
  KernelCode cut = good;
  cut.packedBytes /= 2;
  errorOf(cut);
  KernelCode empty = good;
  empty.packedBytes = 0;
  errorOf(empty);
  KernelCode small = good;
  small.bytes -= 4;
  errorOf(small);
  const KernelCode::Range outside = {somePermutation().hash, good.bytes - 4, 8};
  KernelCode far = good;
  far.ranges = &outside;
  far.rangeCount = 1;
  expectHas(errorOf(far), "too short");
}

TEST(KernelCodes, UnpackOnSeveralThreads) {
  const KernelCodes codes(allGlsl());
  const auto whole = required(codes.source(somePermutation(), CodeFormat::kGlsl));
  std::array<std::string, 4> texts;
  {
    std::vector<std::jthread> threads;
    for (std::string& text : texts) {
      threads.emplace_back([&codes, &text] {
        auto source = codes.source(somePermutation(), CodeFormat::kGlsl);
        if (source) text = *std::move(source);
      });
    }
  }
  for (const std::string& text : texts) EXPECT_EQ(text, *whole);
}

TEST(CarriedKernels, AreThoseOfTheListWithTheirSizes) {
  const std::vector<CarriedKernel> carried = carriedKernels(allCode());
  std::map<CodeFormat, size_t> kernels;
  uint64_t packed = 0, unpacked = 0;
  for (const CarriedKernel& kernel : carried) {
    ++kernels[kernel.format];
    packed += kernel.packedBytes;
    unpacked += kernel.bytes;
    EXPECT_GT(kernel.permutations, 0u);
  }
  for (const CodeFormat format : {CodeFormat::kSpirv, CodeFormat::kGlsl, CodeFormat::kEssl})
    EXPECT_EQ(kernels[format], allKernels().size()) << codeFormatName(format);
  // An engine ships this code.
  EXPECT_LT(packed, 6u << 20);
  EXPECT_GT(unpacked, packed);
  EXPECT_EQ(allSpirv().size() + allGlsl().size() + allEssl().size(), carried.size());
}

// The README's sizes, in MB with one digit.
TEST(CarriedKernels, HaveTheSizesThatTheReadmeStates) {
  const std::string readme = textOf(std::string(PELAGE_SOURCE_DIR) + "/README.md");
  std::smatch stated;
  ASSERT_TRUE(std::regex_search(readme, stated,
                                std::regex(R"(\((\d\.\d), (\d\.\d) and (\d\.\d) MB for all\))")));
  const std::array<KernelCodeList, 3> lists = {allSpirv(), allGlsl(), allEssl()};
  for (size_t i = 0; i < lists.size(); ++i) {
    double bytes = 0;
    for (const CarriedKernel& kernel : carriedKernels(lists[i]))
      bytes += static_cast<double>(kernel.packedBytes);
    EXPECT_NEAR(std::atof(stated[i + 1].str().c_str()), bytes / 1e6, 0.051)
        << "format " << i << ": write the size anew in README.md";
  }
}

}  // namespace
}  // namespace pelage::test
