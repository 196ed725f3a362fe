// A time among samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pelage::bake {

struct SampleTime {
  uint64_t sample = 0;  ///< the one before
  double share = 0;     ///< of the one behind it, 0..1; 0: that one is not needed
};

/// \param position  in samples from the first one; any finite number. A time that is a sample but
/// for rounding is that sample. \param count  at least 1
inline SampleTime sampleAt(double position, uint64_t count) {
  constexpr double kRounding = 1e-6;
  const double clamped = std::clamp(position, 0.0, static_cast<double>(count - 1));
  const double nearest = std::round(clamped);
  if (std::abs(clamped - nearest) < kRounding) return {static_cast<uint64_t>(nearest), 0};
  const double before = std::floor(clamped);
  return {static_cast<uint64_t>(before), clamped - before};
}

}  // namespace pelage::bake
