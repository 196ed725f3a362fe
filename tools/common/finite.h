// Tests for numbers that are not finite.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace pelage::tools {

/// True if all floats of a vector or a transform are finite.
template <class Floats>
bool isFinite(const Floats& value) {
  const auto floats = std::bit_cast<std::array<float, sizeof(Floats) / sizeof(float)>>(value);
  return std::all_of(floats.begin(), floats.end(), [](float f) { return std::isfinite(f); });
}

}  // namespace pelage::tools
