// What strands collide with inside the solve.
#pragma once

#include "pelage/types.h"

namespace pelage {

/// A sphere or a tapered capsule: all spheres whose centre and radius lie between two ends.
struct CapsuleCollider {
  Float3 head = {};       ///< centre of the one end in world space [m]
  float headRadius = 0;   ///< [m], >= 0
  Float3 tail = {};       ///< centre of the other end; equal to the head for a sphere
  float tailRadius = 0;   ///< [m], >= 0
  float friction = 0.3f;  ///< Coulomb coefficient, >= 0
  /// Spin in world space [rad/s]: of a capsule about its axis (the rest of it is in the motion of
  /// the ends), of a sphere about any. It moves nothing, but drags hair along by friction.
  Float3 angularVelocity = {};
  bool operator==(const CapsuleCollider&) const = default;
};

}  // namespace pelage
