#include "shading/light_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/finite.h"

namespace pelage::detail {

namespace {

constexpr float kRightAngle = 1.570797f;  // pi / 2, rounded up

std::string coneFaultOf(const Light& light) {
  if (!(light.outerConeAngle >= 0 && light.outerConeAngle <= kRightAngle))
    return fmt::format("outerConeAngle is {}, but must be in 0..pi/2", light.outerConeAngle);
  if (!(light.innerConeAngle >= 0 && light.innerConeAngle <= light.outerConeAngle))
    return fmt::format("innerConeAngle is {}, but must be in 0..outerConeAngle ({})",
                       light.innerConeAngle, light.outerConeAngle);
  if (light.outerConeAngle > 0 && !light.hasPosition)
    return fmt::format("outerConeAngle is {}, but only a light with hasPosition has a cone",
                       light.outerConeAngle);
  return {};
}

std::string shadowFaultOf(const Light& light) {
  if (light.shadowSize < kMinShadowSize || light.shadowSize > kMaxShadowSize)
    return fmt::format("shadowSize is {}, but must be in {}..{}", light.shadowSize, kMinShadowSize,
                       kMaxShadowSize);
  if (light.shadow == HairShadow::kDeep &&
      (light.shadowLayers == 0 || light.shadowLayers > kMaxShadowLayers))
    return fmt::format("shadowLayers is {}, but must be in 1..{}", light.shadowLayers,
                       kMaxShadowLayers);
  const std::pair<const char*, float> numbers[] = {{"shadowBias", light.shadowBias},
                                                   {"shadowLayerRange", light.shadowLayerRange},
                                                   {"shadowVolume", light.shadowVolume}};
  for (const auto& [name, number] : numbers)
    if (!(number >= 0) || !std::isfinite(number))
      return fmt::format("{} is {}, but must be finite and >= 0", name, number);
  return {};
}

std::string opaqueFaultOf(const OpaqueShadow& map) {
  if (map.width - 1 >= kMaxShadowSize || map.height - 1 >= kMaxShadowSize)
    return fmt::format("opaque.width and opaque.height are {} x {}, but must be in 1..{}",
                       map.width, map.height, kMaxShadowSize);
  if (!isFinite(map.worldToClip)) return "opaque.worldToClip has values that are not finite";
  if (!(map.bias >= 0) || !std::isfinite(map.bias))
    return fmt::format("opaque.bias is {}, but must be finite and >= 0", map.bias);
  return {};
}

}  // namespace

std::string numberFaultOf(const Light& light) {
  if (std::string fault = coneFaultOf(light); !fault.empty()) return fault;
  if (light.shadow != HairShadow::kNone)
    if (std::string fault = shadowFaultOf(light); !fault.empty()) return fault;
  return light.opaque.depth != BufferId::kInvalid ? opaqueFaultOf(light.opaque) : std::string();
}

// StrandLight.cone: a smooth step in the cosine, as in glTF's KHR_lights_punctual, whose code does
// not light the middle of cones below 0.045 rad in full.
Float4 coneOf(const Light& light, Float3 axis) {
  if (!light.hasPosition || !(light.outerConeAngle > 0)) return {};
  // Cosines of nearly 1 are rounded by 6e-8. Angles from 1.5e-3 rad on have a smaller step.
  constexpr double kSteepest = 1e6;
  const double outer = std::cos(double{light.outerConeAngle});
  const double range = std::cos(double{light.innerConeAngle}) - outer;
  const double scale = 1 / std::max(range, 1 / kSteepest);
  const auto steep = static_cast<float>(scale);
  return {axis.x * steep, axis.y * steep, axis.z * steep, static_cast<float>(-outer * scale)};
}

}  // namespace pelage::detail
