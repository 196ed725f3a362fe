// Spheres and tapered capsules that strands collide with.
#pragma once

#include "pelage/types.h"

namespace pelage {

/// A sphere or a tapered capsule: the union of all spheres whose center and radius lie between two
/// ends.
struct CapsuleCollider {
  Float3 head = {};       ///< center of one end in world space [m]
  float headRadius = 0;   ///< [m], >= 0
  Float3 tail = {};       ///< center of the other end [m]; equal to the head for a sphere
  float tailRadius = 0;   ///< [m], >= 0
  float friction = 0.3f;  ///< Coulomb coefficient, >= 0
  /// Angular velocity in world space [rad/s]: of a capsule about its axis (the motion of the ends
  /// has the rest), of a sphere about any axis. It does not move the collider, but drags hair along
  /// by friction.
  Float3 angularVelocity = {};
  bool operator==(const CapsuleCollider&) const = default;
};

}  // namespace pelage
