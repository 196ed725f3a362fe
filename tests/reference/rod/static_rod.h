// Reference for rods at rest: the continuous Kirchhoff rod under its own weight as a boundary value
// problem, solved by shooting. It knows no vertices.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "rest_strand.h"

namespace pelage::rod {

/// A rod of unit linear density, clamped at s = 0 and free at s = length.
struct StaticRod {
  double length = 0;                      ///< [m]
  double bend = 0, twist = 0;             ///< B and G J / (rho A) [m4/s2]
  Vector3d gravity{0, -9.81, 0};          ///< [m/s2]
  std::function<Vector3d(double)> curls;  ///< rest Darboux vector at s, in the material frame [1/m]
  std::function<double(double)> stiffness = {};  ///< factor of bend and twist at s; none: 1
  Quaterniond clamp;  ///< material frame at s = 0; its x axis is the tangent
  Vector3d origin;    ///< position at s = 0
  int steps = 3000;   ///< Runge-Kutta steps along the rod

  /// Curve points at equal arc lengths, steps + 1 of them; nothing when shooting did not converge.
  /// The load is raised in `loadSteps` steps.
  std::optional<std::vector<Vector3d>> solve(int loadSteps = 10) const;

 private:
  struct Shot {
    std::vector<Vector3d> points;
    Vector3d endMoment;
  };
  Shot shoot(const Vector3d& clampMoment, double load) const;
};

/// Point of a curve of equal arc lengths at a share of its length.
Vector3d pointAt(const std::vector<Vector3d>& curve, double share);

}  // namespace pelage::rod
