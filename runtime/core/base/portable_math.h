// Sine, cosine and smooth steps with the same bits on every machine, unlike those of the C library.
#pragma once

#include <algorithm>
#include <cmath>

namespace pelage::detail {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kTwoPi = 2 * kPi;

struct SinCos {
  double sine, cosine;
};

/// For |angle| up to some thousands [rad]; error below 1e-13. Taylor series on |a| <= pi / 4 after
/// reduction to the nearest multiple of pi / 2.
inline SinCos sinCos(double angle) {
  const double quarters = std::floor(angle / (kPi / 2) + 0.5);
  const double a = angle - quarters * (kPi / 2);
  const double a2 = a * a;
  double sine = 0, cosine = 0;
  for (int k = 17; k >= 1; k -= 2) sine = 1 - a2 / ((k + 1) * (k + 2)) * sine;
  for (int k = 16; k >= 0; k -= 2) cosine = 1 - a2 / ((k + 1) * (k + 2)) * cosine;
  sine *= a;
  switch (static_cast<long long>(quarters) & 3) {
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    case 3:
      return {-cosine, sine};
    default:
      return {sine, cosine};
  }
}

inline double saturate(double x) { return std::min(std::max(x, 0.0), 1.0); }

/// 0 below `low`, 1 above `high`, smooth between; `low` may be above `high`.
inline double smoothStep(double low, double high, double x) {
  const double t = saturate((x - low) / (high - low));
  return t * t * (3 - 2 * t);
}

}  // namespace pelage::detail
