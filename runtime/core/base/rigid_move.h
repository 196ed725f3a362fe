// A rigid motion of something in the world, in doubles.
#pragma once

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

}  // namespace pelage::detail
