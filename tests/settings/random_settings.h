// Settings with random values over the whole ranges of the table.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>

#include "pelage/settings/scene_settings.h"

namespace pelage::test {

/// A number within the range: half of them any bits of a float, so of any size.
inline float randomNumber(const Parameter& parameter, std::mt19937& random) {
  for (;;) {
    float value = std::bit_cast<float>(static_cast<uint32_t>(random()));
    if (random() % 2 == 0 && std::isfinite(parameter.low) && std::isfinite(parameter.high))
      value = std::uniform_real_distribution<float>(static_cast<float>(parameter.low),
                                                    static_cast<float>(parameter.high))(random);
    const bool low = parameter.lowIsOpen ? value > parameter.low : value >= parameter.low;
    if (std::isfinite(value) && low && value <= parameter.high) return value;
  }
}

inline ParameterValue randomValue(const Parameter& parameter, std::mt19937& random) {
  switch (parameter.type) {
    case ParameterType::kBool:
      return random() % 2 == 0;
    case ParameterType::kCount: {
      if (parameter.isPowerOfTwo) return uint64_t{1} << (random() % 4);
      const auto low = static_cast<uint64_t>(parameter.low);
      const uint64_t high =
          parameter.high >= 0x1p64 ? ~uint64_t{0} : static_cast<uint64_t>(parameter.high);
      return std::uniform_int_distribution<uint64_t>(low, high)(random);
    }
    case ParameterType::kFloat:
      if (parameter.takesInfinity && random() % 4 == 0)
        return std::numeric_limits<float>::infinity();
      return randomNumber(parameter, random);
    case ParameterType::kVector:
    case ParameterType::kColor: {
      const float x = randomNumber(parameter, random), y = randomNumber(parameter, random);
      return Float3{x == 0 && !parameter.takesZero ? 1 : x, y, randomNumber(parameter, random)};
    }
    case ParameterType::kCurve: {
      ParameterCurve curve;
      for (float& value : curve) value = randomNumber(parameter, random);
      return curve;
    }
    case ParameterType::kChoice:
      break;
  }
  return uint64_t{random() % parameter.choices.size()};
}

/// About `share` of all parameters changed, and any number of lights.
inline SceneSettings randomSettings(std::mt19937& random, double share) {
  SceneSettings settings;
  settings.lights.resize(random() % (kMaxLights + 1));
  for (const SettingsSection& section : settingsSections())
    for (size_t i = 0; i < section.count(settings); ++i)
      for (const Parameter& parameter : section.parameters)
        if (std::uniform_real_distribution<double>()(random) < share)
          section.set(settings, parameter, randomValue(parameter, random), i);
  for (Light& light : settings.lights)
    if (light.innerConeAngle > light.outerConeAngle)
      std::swap(light.innerConeAngle, light.outerConeAngle);
  return settings;
}

}  // namespace pelage::test
