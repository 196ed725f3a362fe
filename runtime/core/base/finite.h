// Tests for numbers that are not finite.
#pragma once

#include <cmath>

#include "pelage/types.h"

namespace pelage::detail {

inline bool isFinite(const Float3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool isFinite(const Float4& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && std::isfinite(v.w);
}
inline bool isFinite(const AffineTransform& m) {
  return isFinite(m.rows[0]) && isFinite(m.rows[1]) && isFinite(m.rows[2]);
}
inline bool isFinite(const Matrix4& m) {
  return isFinite(m.rows[0]) && isFinite(m.rows[1]) && isFinite(m.rows[2]) && isFinite(m.rows[3]);
}

}  // namespace pelage::detail
