// Arithmetic of Float3.
#pragma once

#include <cmath>

#include "pelage/types.h"

namespace sample {

/// a + factor * b
inline pelage::Float3 add(const pelage::Float3& a, const pelage::Float3& b, float factor = 1) {
  return {a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z};
}
inline float dot(const pelage::Float3& a, const pelage::Float3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline pelage::Float3 cross(const pelage::Float3& a, const pelage::Float3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// `a` is not 0.
inline pelage::Float3 unit(const pelage::Float3& a) { return add({}, a, 1 / std::sqrt(dot(a, a))); }

}  // namespace sample
