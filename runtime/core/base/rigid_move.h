// A rigid motion of something in the world, in doubles.
#pragma once

#include <optional>

#include "base/local_origin.h"
#include "base/vector3.h"

namespace pelage::detail {

/// p -> rotate(rotation, p) + shift.
struct RigidMove {
  UnitQuaternion<double> rotation = {};
  Vector3<double> shift = {};

  Vector3<double> operator()(const Vector3<double>& p) const { return rotate(rotation, p) + shift; }
  /// This one after another one.
  RigidMove after(const RigidMove& first) const {
    return {normalized(rotation * first.rotation), (*this)(first.shift)};
  }
};

/// A rigid motion of data that the host has in world space: a shift of the world's origin, or the
/// teleport of an object.
struct WorldMove {
  RigidMove rigid;
  ShiftedFloats* shifted = nullptr;  ///< shift: the exact values; nullptr: a teleport
  double extent = 0;                 ///< bounds the coordinates that are rounded anew [m]
  std::optional<LocalOrigin> origin = std::nullopt;  ///< teleport: that the object's state gets

  void point(Float3& p) const {
    if (shifted != nullptr)
      shifted->shift(p, rigid.shift);
    else
      p = toFloat3(rigid(toVector(p)));
  }
  void direction(Float3& v) const {
    if (shifted == nullptr) v = toFloat3(rotate(rigid.rotation, toVector(v)));
  }
};

}  // namespace pelage::detail
