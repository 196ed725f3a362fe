// The type of the generated tables of code. This header includes little, because a build compiles
// it once for each kernel and API.
#pragma once

#include <stdint.h>

namespace pelage {

struct Kernel;

enum class CodeFormat : uint8_t {
  kSpirv,
  kGlsl,  ///< GLSL 450 core
  kEssl,  ///< ESSL 320
  kWgsl,
};

/// The code of a kernel's permutations in one format, one behind the other and compressed (zstd).
struct KernelCode {
  /// Where a permutation lies in the unpacked bytes.
  struct Range {
    uint64_t variant;  ///< KernelVariant::hash
    uint32_t offset, size;
  };

  const Kernel* kernel;
  CodeFormat format;
  const void* packed;
  uint32_t packedBytes;
  uint32_t bytes;  ///< unpacked
  const Range* ranges;
  uint32_t rangeCount;  ///< one for each of Kernel::variants
};

}  // namespace pelage
