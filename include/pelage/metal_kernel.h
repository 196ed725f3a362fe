// The types of the tables that `pelage-codegen --msl` writes for Metal. Metal has no sets, so each
// permutation has slots of its own. Compiled, never run: docs/metal_d3d12.md.
#pragma once

#include <cstdint>
#include <span>

namespace pelage {

/// An argument table of Metal. Each stage has one of each.
enum class MetalTable : uint8_t { kBuffer, kTexture, kSampler };

/// The slot of a resource.
struct MetalBinding {
  uint8_t set;       ///< as in VariantBinding
  uint8_t entry;     ///< as in VariantBinding
  MetalTable table;  ///< where the slot is
  uint8_t slot;      ///< `[[buffer(slot)]]`, `[[texture(slot)]]` or `[[sampler(slot)]]`
  uint32_t bytes;    ///< of a constant block, a multiple of 16; else 0
  bool operator==(const MetalBinding&) const = default;
};

/// A permutation as Metal needs it.
struct MetalKernel {
  static constexpr uint8_t kNone = 255;  ///< no slot

  uint64_t variant;                        ///< KernelVariant::hash
  const char* file;                        ///< its MSL, in the folder msl
  const char* function;                    ///< the name of its function in the library
  std::span<const MetalBinding> bindings;  ///< ascending by (set, entry)
  /// First buffer slot for Pass::vertices. Attributes may not reach beyond the stride in Metal: one
  /// with VertexAttribute::offset o is at o % stride of slot `vertexBuffer + o / stride`, where the
  /// buffer is bound `o / stride * stride` bytes further. kNone: the kernel has no vertex inputs.
  uint8_t vertexBuffer;
  /// Buffer slot for an array of uints: at the index of a buffer's slot, its size in bytes. kNone:
  /// the permutation asks for no size.
  uint8_t sizes;
  uint32_t threads[3];        ///< compute: threads a threadgroup; else 0
  uint32_t threadgroupBytes;  ///< memory that the function declares; nothing is to be set
};

/// Limits of the GPU families Mac2 and Apple6 (A13), and of later ones.
/// Source: Metal Feature Set Tables, Apple.
struct MetalLimits {
  uint32_t slots[3] = {31, 128, 16};  ///< by MetalTable, of a stage
  uint32_t threads = 1024;            ///< of a threadgroup
  uint32_t threadgroupBytes = 32768;
};
inline constexpr MetalLimits kMetalLimits;

/// Returns the entry of a permutation; nullptr if `kernels` lacks it.
constexpr const MetalKernel* findMetalKernel(std::span<const MetalKernel> kernels,
                                             uint64_t variant) {
  for (const MetalKernel& kernel : kernels)
    if (kernel.variant == variant) return &kernel;
  return nullptr;
}

}  // namespace pelage
