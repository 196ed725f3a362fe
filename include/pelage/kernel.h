// The types of the generated kernel tables (pelage/kernels.h, and the header that
// pelage_add_kernels() makes for an engine's own HLSL).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "pelage/layout.h"

namespace pelage {

/// A resource that a permutation really uses, after optimisation.
struct VariantBinding {
  uint8_t set;    ///< index into Kernel::layouts
  uint8_t entry;  ///< index into that layout's entries
  Access access;  ///< what this permutation does with it
};

/// A specialization constant, with its value when nobody sets it.
struct SpecConstant {
  const char* name;
  uint32_t id;
  uint32_t defaultBits;  ///< the 32 bits of the bool, int, uint or float
};

/// A value for a specialization constant: VkSpecializationInfo on Vulkan, a `#define` of
/// SPIRV_CROSS_CONSTANT_ID_<id> after `#version` on GL.
struct SpecValue {
  uint32_t id;
  uint32_t bits;
  bool operator==(const SpecValue&) const = default;
};

struct Kernel;

/// One compiled permutation of a kernel.
struct KernelVariant {
  const Kernel* kernel;
  const char* key;  ///< "wind=1 globalShape=0"; empty when the kernel has no axes
  std::span<const uint32_t> spirv;
  std::string_view glsl;                     ///< GLSL 450 core
  std::string_view essl;                     ///< ESSL 320
  std::span<const VariantBinding> bindings;  ///< ascending by (set, entry)
  uint32_t groupSize[3];                     ///< compute: threads a group; else 0
  uint64_t hash;                             ///< of the SPIR-V; equal variants are one object
};

/// A kernel: one entry point in one file, both of this name.
struct Kernel {
  const char* name;  ///< file, entry point, pass and timer
  Stage stage;
  std::span<const LayoutTable* const> layouts;  ///< index = set
  std::span<const SpecConstant> specConstants;
  std::span<const KernelVariant* const> variants;  ///< distinct ones
};

/// Whether two kernels can be the stages of one draw: they have the same layouts, or one of them
/// the first layouts of the other.
constexpr bool layoutsFit(const Kernel& a, const Kernel& b) {
  const size_t shared = a.layouts.size() < b.layouts.size() ? a.layouts.size() : b.layouts.size();
  for (size_t set = 0; set < shared; ++set)
    if (a.layouts[set] != b.layouts[set]) return false;
  return true;
}

}  // namespace pelage
