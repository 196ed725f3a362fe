// From the axes and the unit of a file to meters with y up.
#pragma once

#include "pelage/authoring/hair_curves.h"
#include "pelage/types.h"

namespace pelage::detail {

constexpr bool isScale(float scale) { return scale >= 1e-9f && scale <= 1e9f; }  // false for NaN

/// A direction, or a point once scaled: turned, then mirrored.
inline Float3 turned(const Float3& v, UpAxis upAxis, bool invertZ) {
  Float3 r = v;
  if (upAxis == UpAxis::kX) r = {-v.y, v.x, v.z};
  if (upAxis == UpAxis::kZ) r = {v.x, v.z, -v.y};
  if (invertZ) r.z = -r.z;
  return r;
}

}  // namespace pelage::detail
