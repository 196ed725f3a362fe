// The code of kernels for an API. It lies compressed in libraries of its own, one object a kernel:
// a program carries the code of the APIs and kernels that it names, and no other.
//
//   pelage/spirv.h  library pelage::spirv  kDrawStrandsSpirv ... allSpirv()
//   pelage/glsl.h   library pelage::glsl   kDrawStrandsGlsl  ... allGlsl()    GLSL 450 core
//   pelage/essl.h   library pelage::essl   kDrawStrandsEssl  ... allEssl()    ESSL 320
//   pelage/code.h   library pelage::code   allCode(): the three of them
//
// With PELAGE_WGSL there are library pelage::wgsl and its allWgsl(), too: docs/webgpu.md
//
// pelage_add_kernels() makes the same headers and libraries of an engine's own HLSL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pelage/export.h"
#include "pelage/kernel.h"
#include "pelage/kernel_code_table.h"
#include "pelage/result.h"

namespace pelage {

/// Generated tables, or a selection of them.
using KernelCodeList = std::span<const KernelCode* const>;

/// The code of one kernel in a program.
struct CarriedKernel {
  const char* kernel = "";
  CodeFormat format = CodeFormat::kSpirv;
  uint32_t permutations = 0;  ///< distinct ones
  uint64_t packedBytes = 0;   ///< in the program
  uint64_t bytes = 0;         ///< unpacked, all permutations
};

/// One entry for each table of a list, in its order. Of allSpirv(): all SPIR-V of pelage.
PELAGE_API std::vector<CarriedKernel> carriedKernels(KernelCodeList list);

/// "SPIR-V", "GLSL", "ESSL" or "WGSL".
PELAGE_API const char* codeFormatName(CodeFormat format);

/// Finds and unpacks the code of permutations, for an executor.
///
/// Threads: what is const may be called by any number at a time.
class PELAGE_API KernelCodes {
 public:
  KernelCodes() = default;
  explicit KernelCodes(KernelCodeList list) { add(list); }

  /// Adds tables, of one format or several; those that are known already change nothing. The tables
  /// must have static lifetime, as the generated ones have.
  void add(KernelCodeList list);

  /// The SPIR-V of a permutation: SPIR-V 1.3, for Vulkan 1.1 and later. Unpacks all permutations of
  /// the kernel, which takes some milliseconds for the largest ones. Errors: kUnsupported when no
  /// table has the permutation; kInvalidFile when the table is damaged.
  Result<std::vector<uint32_t>> spirv(const KernelVariant& variant) const;

  /// The source of a permutation, kGlsl, kEssl or kWgsl. Errors: as spirv().
  Result<std::string> source(const KernelVariant& variant, CodeFormat format) const;

 private:
  struct Place {
    const KernelCode* code;
    uint32_t range;
  };
  Result<std::vector<char>> unpack(const KernelVariant& variant, CodeFormat format) const;
  std::map<std::pair<uint64_t, CodeFormat>, Place> places_;  // by KernelVariant::hash
};

}  // namespace pelage
