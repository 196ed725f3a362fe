// A number and the range that it has to be in.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>

namespace pelage::detail {

struct Range {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  const char* name;
  float value;
  float low = -kInfinity, high = kInfinity;
  bool above = false;  ///< `low` itself is out of range
};

/// Describes what is wrong with a number; empty where it is in its range. NaN and infinity never
/// are.
inline std::string faultOf(const Range& range) {
  const auto [name, value, low, high, above] = range;
  if (std::isfinite(value) && (above ? value > low : value >= low) && value <= high) return {};
  std::string wanted = "finite";
  if (high < Range::kInfinity)
    wanted = fmt::format("in {}..{}", low, high);
  else if (low > -Range::kInfinity)
    wanted += fmt::format(" and {} {}", above ? "above" : "at least", low);
  return fmt::format("{} is {}, but must be {}", name, value, wanted);
}

}  // namespace pelage::detail
