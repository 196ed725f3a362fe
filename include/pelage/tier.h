// Device tiers: what kernels may ask of a device. Every permutation states its tier, and
// pelage-codegen refuses one that needs more (codegen/README.md); docs/limits.md lists them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

#include "pelage/layout.h"

namespace pelage {

/// A class of devices, from the least to the most capable. A kernel of a tier runs on devices of
/// this tier and of all later ones.
enum class Tier : uint8_t {
  kEs,    ///< every OpenGL ES 3.2: 4 storage buffers in compute and pixel kernels
  kBase,  ///< every OpenGL 4.5, Vulkan on GPUs, common ES: 8, and none in vertex kernels
  kWide,  ///< desktop GPUs: 16 in every stage
};

/// All tiers, the least capable one first.
inline constexpr Tier kTiers[] = {Tier::kEs, Tier::kBase, Tier::kWide};

/// "es", "base" or "wide".
constexpr const char* tierName(Tier tier) {
  constexpr const char* kNames[] = {"es", "base", "wide"};
  return kNames[static_cast<uint8_t>(tier)];
}

/// The tier of a name that tierName() gives; nothing for any other name.
constexpr std::optional<Tier> tierFromName(std::string_view name) {
  for (const Tier tier : kTiers)
    if (name == tierName(tier)) return tier;
  return std::nullopt;
}

/// One number for each stage.
struct StageCounts {
  uint32_t compute = 0, vertex = 0, pixel = 0;
  constexpr uint32_t of(Stage stage) const {
    return stage == Stage::kCompute ? compute : stage == Stage::kVertex ? vertex : pixel;
  }
  constexpr bool operator==(const StageCounts&) const = default;
};

/// Limits that a device sets to a kernel.
struct TierLimits {
  StageCounts storageBuffers;         ///< of one kernel
  uint32_t drawStorageBuffers = 0;    ///< of the vertex and the pixel kernel of a draw together
  uint32_t storageBindings = 0;       ///< OpenGL: binding numbers are smaller than this
  StageCounts images;                 ///< storage images of one kernel
  StageCounts uniformBlocks;          ///< of one kernel
  StageCounts textures;               ///< sampled, of one kernel
  uint32_t groupThreads = 0;          ///< threads of a work group
  uint32_t groupSize[3] = {0, 0, 0};  ///< threads of a work group on each axis
  uint32_t groupSharedBytes = 0;      ///< groupshared memory of a work group
  constexpr bool operator==(const TierLimits&) const = default;
};

/// Limits that every device of a tier meets. docs/limits.md names the sources.
constexpr TierLimits limitsOf(Tier tier) {
  // Vulkan and ES 3.2 promise 128 threads and 16 KiB to base, too; all desktop GPUs have more.
  constexpr TierLimits kEs = {{4, 0, 4},      4,    4, {4, 0, 4}, {12, 12, 12}, {16, 16, 16}, 128,
                              {128, 128, 64}, 16384};
  constexpr TierLimits kBase = {{8, 0, 8},      8,    8, {8, 0, 8}, {12, 12, 12}, {16, 16, 16}, 128,
                                {128, 128, 64}, 16384};
  constexpr TierLimits kWide = {
      {16, 16, 16}, 16, 16, {8, 0, 8}, {12, 12, 12}, {16, 16, 16}, 1024, {1024, 1024, 64}, 32768};
  return tier == Tier::kEs ? kEs : tier == Tier::kBase ? kBase : kWide;
}

/// Limits that every WebGPU device meets. They are no Tier: a kernel of tier `wide` may keep to
/// them, and one of tier `es` may not, because pixel kernels write no storage buffers there. Of
/// OpenGL's members, storageBindings and drawStorageBuffers say nothing. docs/webgpu.md
inline constexpr TierLimits kWebgpuLimits = {
    {8, 8, 8}, 16, 16, {4, 0, 4}, {12, 12, 12}, {16, 16, 16}, 256, {256, 256, 64}, 16384};

/// Each limit is the smaller one of both.
constexpr TierLimits lowerOf(const TierLimits& a, const TierLimits& b) {
  const auto counts = [](const StageCounts& x, const StageCounts& y) {
    return StageCounts{std::min(x.compute, y.compute), std::min(x.vertex, y.vertex),
                       std::min(x.pixel, y.pixel)};
  };
  return {counts(a.storageBuffers, b.storageBuffers),
          std::min(a.drawStorageBuffers, b.drawStorageBuffers),
          std::min(a.storageBindings, b.storageBindings),
          counts(a.images, b.images),
          counts(a.uniformBlocks, b.uniformBlocks),
          counts(a.textures, b.textures),
          std::min(a.groupThreads, b.groupThreads),
          {std::min(a.groupSize[0], b.groupSize[0]), std::min(a.groupSize[1], b.groupSize[1]),
           std::min(a.groupSize[2], b.groupSize[2])},
          std::min(a.groupSharedBytes, b.groupSharedBytes)};
}

/// The most capable tier of which a device with these limits has everything; nothing when it lacks
/// something of Tier::kEs.
constexpr std::optional<Tier> tierOf(const TierLimits& limits) {
  std::optional<Tier> best;
  for (const Tier tier : kTiers)
    if (lowerOf(limits, limitsOf(tier)) == limitsOf(tier)) best = tier;
  return best;
}

}  // namespace pelage
