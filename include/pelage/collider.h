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

/// The look of contact records in Scene::drawContacts(): one needle each, from the vertex along the
/// contact's normal. docs/contact.md has the colors.
struct ContactLook {
  float length = 0.004f;        ///< length of a sticking contact [m], > 0; sliding ones have half
  float width = 4;              ///< width at the vertex [pixels], > 0
  float deepestDepth = 0.001f;  ///< a vertex this deep is red [m], > 0
};

}  // namespace pelage
