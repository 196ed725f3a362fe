// Points of assets, in double precision and in range.
#pragma once

#include <cmath>

#include "base/vector3.h"
#include "pelage/hair_asset.h"

namespace pelage::detail {

using Vector = Vector3<double>;

inline Vector toVector(const Float4& p) { return {double{p.x}, double{p.y}, double{p.z}}; }

/// Whether a point is finite and within kMaxCoordinate.
inline bool isCoordinate(const Float3& p) {
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate;
}

}  // namespace pelage::detail
