#include "pelage/simulation_settings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace pelage {
namespace {

constexpr uint32_t kMaxSubStepsOfAStep = 32;
constexpr float kMax = std::numeric_limits<float>::max();

struct Range {
  const char* name;
  float value, low, high;
};

Error outOfRange(const std::string& name, const std::string& value, const std::string& range) {
  return {ErrorCode::kInvalidArgument,
          "simulation setting '" + name + "' is " + value + ", but must be " + range};
}

std::string text(float value) {
  std::string digits = std::to_string(value);
  while (digits.find('.') != std::string::npos && (digits.back() == '0' || digits.back() == '.')) {
    const bool point = digits.back() == '.';
    digits.pop_back();
    if (point) break;
  }
  return digits;
}

Result<void> check(const Range& range) {
  if (!std::isfinite(range.value)) {
    return outOfRange(range.name, std::isnan(range.value) ? "not a number" : "infinite", "finite");
  }
  if (range.value < range.low || range.value > range.high) {
    return outOfRange(range.name, text(range.value),
                      range.high == kMax ? "at least " + text(range.low)
                                         : "in " + text(range.low) + ".." + text(range.high));
  }
  return {};
}

}  // namespace

float valueAt(const ParameterCurve& curve, float share) {
  const float slot = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(curve.size() - 1);
  const auto left = std::min(static_cast<size_t>(slot), curve.size() - 2);
  const float t = slot - static_cast<float>(left);
  return curve[left] + (curve[left + 1] - curve[left]) * t;
}

Result<void> validate(const SimulationSettings& s) {
  const Range ranges[] = {
      {"gravity.x", s.gravity.x, -kMax, kMax},
      {"gravity.y", s.gravity.y, -kMax, kMax},
      {"gravity.z", s.gravity.z, -kMax, kMax},
      {"damping", s.damping, 0, 1},
      {"bendLength", s.bendLength, 0, 10},
      {"twistRatio", s.twistRatio, 0.05f, 10},
      {"relaxationTime", s.relaxationTime, 0, 1},
      {"sagCompensation", s.sagCompensation, 0, 1},
      {"localStiffness", s.localStiffness, 0, 1},
      {"globalStiffness", s.globalStiffness, 0, 1},
      {"globalRange", s.globalRange, 0, 1},
      {"vspCoefficient", s.vspCoefficient, 0, 1},
      {"wind.velocity.x", s.wind.velocity.x, -kMax, kMax},
      {"wind.velocity.y", s.wind.velocity.y, -kMax, kMax},
      {"wind.velocity.z", s.wind.velocity.z, -kMax, kMax},
      {"wind.gustStrength", s.wind.gustStrength, 0, 1},
      {"wind.gustPeriod", s.wind.gustPeriod, 1e-3f, kMax},
      {"wind.strandVariation", s.wind.strandVariation, 0, 1},
      {"sleep.speed", s.sleep.speed, 0, kMax},
      {"sleep.time", s.sleep.time, 0, kMax},
      {"sleep.wakeDistance", s.sleep.wakeDistance, 0, kMax},
      {"contact.stiffness", s.contact.stiffness, 0, 1},
      {"contact.friction", s.contact.friction, 0, 1},
      {"contact.cellSize", s.contact.cellSize, 1e-3f, 1},
      {"airDrag", s.airDrag, 0, kMax},
      {"maxSpeed", s.maxSpeed, 1e-6f, kMax},
      {"tipSeparation", s.tipSeparation, 0, kMax},
  };
  for (const Range& range : ranges)
    if (Result<void> checked = check(range); !checked) return checked;
  const std::pair<const char*, const ParameterCurve*> curves[] = {
      {"curves.stiffness", &s.curves.stiffness},
      {"curves.globalStiffness", &s.curves.globalStiffness},
      {"curves.damping", &s.curves.damping}};
  for (const auto& [name, curve] : curves)
    for (const float value : *curve)
      if (Result<void> checked = check({name, value, 0, kMax}); !checked) return checked;
  // An infinite threshold is valid: it means never.
  if (!(s.vspThreshold > 0)) return outOfRange("vspThreshold", text(s.vspThreshold), "above 0");
  if (s.solver != Solver::kExact && s.solver != Solver::kClassic) {
    return outOfRange("solver", std::to_string(static_cast<int>(s.solver)), "kExact or kClassic");
  }
  if (s.subSteps < 1 || s.subSteps > kMaxSubStepsOfAStep) {
    return outOfRange("subSteps", std::to_string(s.subSteps),
                      "in 1.." + std::to_string(kMaxSubStepsOfAStep));
  }
  if (s.maxSubSteps < 1 || s.maxSubSteps > kMaxSubStepsOfAStep) {
    return outOfRange("maxSubSteps", std::to_string(s.maxSubSteps),
                      "in 1.." + std::to_string(kMaxSubStepsOfAStep));
  }
  if (s.localIterations < 1 || s.localIterations > 16)
    return outOfRange("localIterations", std::to_string(s.localIterations), "in 1..16");
  if (s.lengthIterations < 1 || s.lengthIterations > 16)
    return outOfRange("lengthIterations", std::to_string(s.lengthIterations), "in 1..16");
  return {};
}

}  // namespace pelage
