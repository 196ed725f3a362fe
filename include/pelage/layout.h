// The types of the generated layout tables (pelage/layouts.h). A layout is one descriptor set: the
// resources that a group of kernels shares, with their slots on Vulkan and on GL.
#pragma once

#include <cstdint>
#include <span>

namespace pelage {

enum class ResourceKind : uint8_t {
  kUniformBuffer,   ///< Vulkan uniform buffer (dynamic offset), GL uniform block
  kStorageBuffer,   ///< Vulkan storage buffer, GL shader storage block
  kSampledTexture,  ///< Vulkan sampled image or combined image-sampler, GL sampler
  kStorageTexture,  ///< Vulkan storage image, GL image
  kSampler,         ///< Vulkan sampler; on GL it is merged into the textures
};

/// How a kernel touches a resource; a bit set.
enum class Access : uint8_t { kNone = 0, kRead = 1, kWrite = 2, kReadWrite = 3 };

constexpr Access operator|(Access a, Access b) {
  return static_cast<Access>(static_cast<uint8_t>(a) | static_cast<uint8_t>(b));
}
constexpr bool reads(Access a) { return (static_cast<uint8_t>(a) & 1) != 0; }
constexpr bool writes(Access a) { return (static_cast<uint8_t>(a) & 2) != 0; }

enum class Stage : uint8_t { kCompute, kVertex, kPixel };

/// Bits of shader stages; stageBit(stage) gives one.
using StageMask = uint8_t;
constexpr StageMask stageBit(Stage stage) {
  return static_cast<StageMask>(1u << static_cast<uint8_t>(stage));
}

/// One resource of a layout.
struct LayoutEntry {
  const char* name;        ///< as declared in HLSL
  const char* structName;  ///< element or block type; the generated host struct has this name
  ResourceKind kind;
  Access access;     ///< union over all kernels and permutations of the layout
  StageMask stages;  ///< union over all kernels of the layout
  uint32_t stride;   ///< bytes an element (storage buffer) or a block (uniform buffer); else 0
  uint32_t binding;  ///< Vulkan binding within the set
  /// GL binding point of a uniform block, texture or image: dense for each kind over a group's
  /// sets. 0 for storage buffers: each permutation numbers its own (VariantBinding::glBinding).
  uint32_t glBinding;
};

/// One descriptor set.
struct LayoutTable {
  const char* name;   ///< "SimPosTan" for CreateSimPosTanLayout
  const char* group;  ///< layouts of one group are bound together; the first group that has it
  uint32_t set;       ///< Vulkan set number, the same in every group that has it
  std::span<const LayoutEntry> entries;
};

}  // namespace pelage
