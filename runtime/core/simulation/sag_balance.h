// Rest shapes of the exact solver that gravity bends into the bind shape.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/vector3.h"

namespace pelage::detail {

/// The load that rest shapes balance, and what the rod has against it. Without an acceleration
/// there is nothing to balance, and all members are 0.
struct SagLoad {
  Vector3<double> acceleration;  ///< share of gravity, in bind space [m/s2]
  double bend = 0, twist = 0;    ///< B and Bt of the solver [m4/s2]
  double targetSpring = 0;       ///< of the global shape [1/s2]
  double targetRange = 0;        ///< fraction of the strand on which it acts in full
  bool acts() const { return dot(acceleration, acceleration) > 0; }
};
bool operator==(const SagLoad& a, const SagLoad& b);

/// A strand of n vertices in its bind pose.
struct BoundRod {
  UnitQuaternion<double> rootFrame;           ///< of edge 0; x axis = tangent
  std::span<const Vector3<double>> tangents;  ///< [n - 1] unit, of edges
  std::span<const double> lengths;            ///< [n - 1] of edges [m]
  std::span<const double> voronoiLengths;     ///< [n], > 0 [m]
  std::span<const double> stiffness;          ///< [n] factors on B and Bt, > 0
  std::span<const double> springs;            ///< [n] to the bind position [1/s2]; or empty
};

/// Rotations from edge i - 1 to edge i, in the frame of edge i - 1.
struct SagJoint {
  UnitQuaternion<double> rest;  ///< without load; without a twist
  UnitQuaternion<double> bind;  ///< in the bind shape, with the twist that the load makes
};

/// Finds the joints that balance the load in the bind shape, from tip to root the moments, from
/// root to tip the joints: O(n), exact for the solver's rod.
/// \param joints  [n - 1]; entry 0 is not used. Joints behind one that cannot carry its moment are
///   those of the bind shape.
/// Returns whether all joints carry their moments.
bool balanceJoints(const BoundRod& rod, const SagLoad& load, std::span<SagJoint> joints);
/// Returns whether a strand with joints of balanceJoints() comes back to its bind shape when it is
/// moved a little: it falls where the load is too large for its stiffness. O(n).
bool isStable(const BoundRod& rod, const SagLoad& load, std::span<const SagJoint> joints);

/// Finds stable joints for the largest fraction of the load that has some.
/// Returns that fraction, 0..1.
double balanceSag(const BoundRod& rod, const SagLoad& load, std::span<SagJoint> joints);

}  // namespace pelage::detail
