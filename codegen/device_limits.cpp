#include "codegen/device_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "pelage/tier.h"

namespace pelage::codegen {
namespace {

bool canBeDrawn(const Unit& vertex, const Unit& pixel, const Manifest& manifest) {
  return vertex.kernel->stage == Stage::kVertex && pixel.kernel->stage == Stage::kPixel &&
         manifest.groupsFit(vertex.kernel->group, pixel.kernel->group);
}

Tier tierOf(const Unit& unit) { return unit.kernel->tierOf(unit.permutation); }

}  // namespace

uint32_t firstStorageBinding(const Unit& unit, const std::vector<Unit>& units,
                             const Manifest& manifest) {
  const auto& own = unit.reflection->resources;
  if (std::none_of(own.begin(), own.end(), [](const Resource& resource) {
        return resource.kind == ResourceKind::kStorageBuffer;
      })) {
    return 0;
  }
  uint32_t first = 0;
  for (const Unit& pixel : units)
    if (canBeDrawn(unit, pixel, manifest)) first = std::max(first, pixel.storageBuffers);
  return first;
}

// All pairs that fit, because nobody says which are drawn. Only a vertex kernel of the wide tier
// has storage buffers, so that no pair of the others can fail.
void checkDraws(const std::vector<Unit>& units, const Manifest& manifest,
                Diagnostics& diagnostics) {
  for (const Unit& vertex : units) {
    const uint32_t own = vertex.storageBuffers;
    if (vertex.kernel->stage != Stage::kVertex || own == 0) continue;
    // PK217 and PK218 have said so.
    if (own > limitsOf(tierOf(vertex)).storageBuffers.vertex) continue;
    for (const Unit& pixel : units) {
      if (!canBeDrawn(vertex, pixel, manifest)) continue;
      const Tier tier = std::max(tierOf(vertex), tierOf(pixel));
      const uint32_t both = own + pixel.storageBuffers, most = limitsOf(tier).drawStorageBuffers;
      if (both <= most) continue;
      diagnostics.error(
          vertex.locate(vertex.kernel->name), "PK702",
          fmt::format("kernels {} and {} have {} storage buffers together; tier {} has {} for both "
                      "stages of a draw: merge some, or put the kernels into groups that do not "
                      "share layouts",
                      vertex.text(), pixel.text(), both, tierName(tier), most));
    }
  }
}

void checkWebgpu(const std::vector<Unit>& units, Diagnostics& diagnostics) {
  for (const Unit& unit : units) {
    if (unit.kernel->whyNotWebgpu(unit.permutation) != nullptr) continue;
    const std::optional<SpirvReader> module = SpirvReader::parse(unit.back.optimised);
    if (!module) continue;
    const auto error = [&](const std::string& what) {
      diagnostics.error(unit.locate(unit.kernel->name), "PK703",
                        fmt::format("kernel {} {}: change it, or name the reason in \"noWebgpu\"",
                                    unit.text(), what));
    };
    const auto check = [&](uint64_t count, uint32_t most, const char* what) {
      if (count > most) error(fmt::format("has {} {}, WebGPU promises {}", count, what, most));
    };
    const Stage stage = unit.kernel->stage;
    const ModuleReflection reflection = reflectModule(*module);
    std::map<ResourceKind, uint32_t> counts;
    for (const Resource& resource : reflection.resources) ++counts[resource.kind];
    check(counts[ResourceKind::kStorageBuffer], kWebgpuLimits.storageBuffers.of(stage),
          "storage buffers");
    check(counts[ResourceKind::kUniformBuffer], kWebgpuLimits.uniformBlocks.of(stage),
          "constant blocks");
    check(counts[ResourceKind::kSampledTexture], kWebgpuLimits.textures.of(stage), "textures");
    check(counts[ResourceKind::kStorageTexture], kWebgpuLimits.images.of(stage), "images");
    check(uint64_t{reflection.groupSize[0]} * reflection.groupSize[1] * reflection.groupSize[2],
          kWebgpuLimits.groupThreads, "threads in a group");
    for (size_t axis = 0; axis < 3; ++axis)
      check(reflection.groupSize[axis], kWebgpuLimits.groupSize[axis], "threads on an axis");
    check(reflection.sharedBytes, kWebgpuLimits.groupSharedBytes, "bytes of groupshared memory");
    if (stage != Stage::kPixel) continue;
    for (const auto& [id, access] : resourceAccess(*module)) {
      if (access == Access::kRead) continue;
      error("writes '" + module->name(id) + "', and pixel kernels write no buffers on WebGPU");
      break;
    }
  }
}

}  // namespace pelage::codegen
