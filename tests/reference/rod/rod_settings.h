// What the exact rod solver is told in a step; SI units.
#pragma once

#include <limits>
#include <span>

#include "rest_strand.h"

namespace pelage::reference {

/// Stiffness and damping, divided by the strand's mass a length (unit linear density).
struct RodMaterial {
  double bend = 1e-3;      ///< B = E I / (rho A) [m4/s2], >= 0; 9.81 (bend length)^3; hair: 1e-3
  double twist = 0.75e-3;  ///< G J / (rho A) [m4/s2], >= 0
  double airDrag = 0;      ///< c [1/s], >= 0; -60 ln(1 - damping)
  double relaxation = 0;   ///< tau of Kelvin-Voigt bending damping [s], >= 0
};

/// A sphere, a tapered capsule (the union of the spheres between two ends) or a half-space that
/// moves in the step.
struct RodCollider {
  Vector3d head, tail;              ///< at the end of the step [m]; equal for a sphere
  Vector3d headBefore, tailBefore;  ///< at the begin of the step [m]
  double headRadius = 0;            ///< [m], >= 0
  double tailRadius = 0;            ///< [m], >= 0
  double friction = 0;              ///< Coulomb coefficient, >= 0
  Vector3d spin = {};    ///< rotation vector of the step about the axis, or a sphere's center [rad]
  Vector3d normal = {};  ///< unit: what is behind the plane through `head`; 0: a capsule

  static RodCollider sphere(const Vector3d& center, double radius, double friction = 0) {
    return capsule(center, center, radius, friction);
  }
  static RodCollider capsule(const Vector3d& a, const Vector3d& b, double radius,
                             double friction = 0) {
    return {a, b, a, b, radius, radius, friction};
  }
  static RodCollider plane(const Vector3d& point, const Vector3d& normal, double friction = 0) {
    RodCollider shape = sphere(point, 0, friction);
    shape.normal = normal;
    return shape;
  }
  /// Begins the next step where the last one ended, and moves by `displacement` in it.
  void move(const Vector3d& displacement) {
    headBefore = head;
    tailBefore = tail;
    head += displacement;
    tail += displacement;
  }
};

struct RodSettings {
  RodMaterial material;
  Vector3d gravity{0, -9.81, 0};  ///< [m/s2]
  Vector3d wind{0, 0, 0};         ///< velocity of the air [m/s]; acts through airDrag
  double globalStiffness = 0;     ///< 0..1: share of the way to the bind pose in 1/60 s
  double globalRange = 1;  ///< 0..1: share of the strand with all of it; fades to 0 at 1.25 times
  bool holdTip = false;    ///< the last vertex stays where the bind pose has it
  /// Share of the root's rigid motion that the whole strand takes part in, 0..1.
  double carry = 0;
  /// Acceleration of the root [m/s2] above which that share grows; it is 1 from twice the value.
  double carryThreshold = std::numeric_limits<double>::infinity();
  std::span<const RodCollider> colliders = {};
  int subSteps = 1;  ///< of a step, >= 1; the root's pose is interpolated
  /// Newton passes: passes after the first one run only while the largest rotation of an edge in
  /// the pass before was above passTolerance [rad].
  int maxPasses = 2;
  int contactPasses = 3;  ///< the same for a strand with contacts
  double passTolerance = 0.04;
  bool backwardEuler = false;  ///< first order in time, instead of BDF2
};

/// Coefficients of a step of length h after one of length hBefore: BDF2 with a varying step, or
/// backward Euler where there is no history or the ratio is outside 0.4..2.1 (Hairer, Norsett and
/// Wanner, Solving Ordinary Differential Equations I, section III.5: stable to 1 + sqrt 2).
/// The backward value is b = u + a2 (u_-1 - u), and u_+1 = b + he du/dt.
struct StepCoefficients {
  double a2 = 0;
  double he = 0;  ///< [s]

  static StepCoefficients of(double h, double hBefore, bool history) {
    const double w = history && hBefore > 0 ? h / hBefore : 0;
    if (!(w >= 0.4 && w <= 2.1)) return {0, h};
    return {-w * w / (1 + 2 * w), h * (1 + w) / (1 + 2 * w)};
  }
};

}  // namespace pelage::reference
