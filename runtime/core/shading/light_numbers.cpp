#include "shading/light_numbers.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "pelage/constants.h"

namespace pelage::detail {

namespace {

constexpr uint32_t kMinSize = 4, kMaxSize = strand_shadow_view::kMaxShadowSize;
constexpr uint32_t kMaxLayers = strand_shadow_view::kMaxShadowLayers;

std::string shadowFaultOf(const Light& light) {
  if (light.shadowSize < kMinSize || light.shadowSize > kMaxSize)
    return fmt::format("shadowSize is {}, but must be in {}..{}", light.shadowSize, kMinSize,
                       kMaxSize);
  if (light.shadow == HairShadow::kDeep &&
      (light.shadowLayers == 0 || light.shadowLayers > kMaxLayers))
    return fmt::format("shadowLayers is {}, but must be in 1..{}", light.shadowLayers, kMaxLayers);
  const std::pair<const char*, float> numbers[] = {{"shadowBias", light.shadowBias},
                                                   {"shadowLayerRange", light.shadowLayerRange},
                                                   {"shadowVolume", light.shadowVolume}};
  for (const auto& [name, number] : numbers)
    if (!(number >= 0) || !std::isfinite(number))
      return fmt::format("{} is {}, but must be finite and >= 0", name, number);
  return {};
}

}  // namespace

std::string numberFaultOf(const Light& light) {
  return light.shadow != HairShadow::kNone ? shadowFaultOf(light) : std::string();
}

}  // namespace pelage::detail
