// The types of the generated kernel tables (pelage/kernels.h, and the header that
// pelage_add_kernels() makes for an engine's own HLSL).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "pelage/layout.h"
#include "pelage/tier.h"

namespace pelage {

/// A resource that a permutation really uses, after optimisation.
struct VariantBinding {
  uint8_t set;    ///< index into Kernel::layouts
  uint8_t entry;  ///< index into that layout's entries
  Access access;  ///< what this permutation does with it
  /// Number of the GL binding point of its kind. Storage buffers are numbered for each permutation:
  /// from 0, those of a vertex kernel from behind all pixel kernels that it can be drawn with.
  uint8_t glBinding = 0;
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

/// Type of a vertex attribute: 32-bit numbers, one to four of them.
enum class VertexFormat : uint8_t {
  kFloat1,
  kFloat2,
  kFloat3,
  kFloat4,
  kUint1,
  kUint2,
  kUint3,
  kUint4,
};
constexpr uint32_t componentsOf(VertexFormat format) {
  return static_cast<uint32_t>(format) % 4 + 1;
}
constexpr bool isInteger(VertexFormat format) { return format >= VertexFormat::kUint1; }

/// An input of a vertex kernel. Vulkan: VkVertexInputAttributeDescription, GL:
/// glVertexAttribFormat() and, for integers, glVertexAttribIFormat().
struct VertexAttribute {
  uint32_t location;
  VertexFormat format;
  uint32_t offset;  ///< bytes from the start of an element; may reach into the next elements
};

/// The attributes that a vertex kernel reads through the fixed-function vertex input. Many devices
/// have no storage buffers in that stage. All are from one buffer, Pass::vertices.
struct VertexInput {
  std::span<const VertexAttribute> attributes;  ///< ascending by location
  uint32_t stride;                              ///< bytes from an element to the next
  bool perInstance;                             ///< else an element a vertex
  /// Bytes of a buffer from which `count` vertices or instances are read.
  constexpr uint64_t bytes(uint64_t count) const {
    uint64_t last = 0;
    for (const VertexAttribute& attribute : attributes) {
      const uint64_t end = attribute.offset + uint64_t{4} * componentsOf(attribute.format);
      last = end > last ? end : last;
    }
    return count == 0 ? 0 : (count - 1) * stride + last;
  }
};

/// Threads of a group of a compute kernel.
struct GroupSize {
  uint32_t x = 1, y = 1, z = 1;
};

/// One compiled permutation of a kernel, without its code (pelage/kernel_code.h).
struct KernelVariant {
  const Kernel* kernel;
  const char* key;  ///< "wind=1 globalShape=0"; empty when the kernel has no axes
  std::span<const VariantBinding> bindings;  ///< ascending by (set, entry)
  uint32_t groupSize[3];                     ///< compute: threads a group; else 0
  /// Hash of the SPIR-V, and of GL binding numbers that do not begin at 0; equal variants are one
  /// object. Finds its code (pelage/kernel_code.h).
  uint64_t hash;
  Tier tier = Tier::kWide;   ///< the devices that it runs on, as the manifest states it
  uint32_t sharedBytes = 0;  ///< groupshared memory of a work group
};

/// A kernel: one entry point in one file, both of this name.
struct Kernel {
  const char* name;  ///< file, entry point, pass and timer
  Stage stage;
  std::span<const LayoutTable* const> layouts;  ///< index = set
  std::span<const SpecConstant> specConstants;
  std::span<const KernelVariant* const> variants;  ///< distinct ones
  const VertexInput* vertexInput = nullptr;        ///< nullptr: none
  /// Dispatches of it may run at the same time although they write the same range of a buffer:
  /// writes are atomic sums, minima or maxima, or each dispatch has elements of its own.
  bool commutes = false;
};

/// The time it took to make a pipeline (Vulkan) or a program (OpenGL).
struct PipelineTime {
  std::string name;  ///< kernel and permutation, of both stages of a draw
  /// On the caller's clock. Several are made at a time, so these overlap.
  double milliseconds = 0;
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
