// Plain mathematical types of the public API, in the memory layout that the kernels read. The
// implementation computes with Eigen, which does not appear in public headers.
#pragma once

#include <cstdint>

namespace pelage {

struct Float2 {
  float x = 0, y = 0;
  bool operator==(const Float2&) const = default;
};

struct Float3 {
  float x = 0, y = 0, z = 0;
  bool operator==(const Float3&) const = default;
};

struct Float4 {
  float x = 0, y = 0, z = 0, w = 0;
  bool operator==(const Float4&) const = default;
};

struct Uint4 {
  uint32_t x = 0, y = 0, z = 0, w = 0;
  bool operator==(const Uint4&) const = default;
};

struct Int4 {
  int32_t x = 0, y = 0, z = 0, w = 0;
  bool operator==(const Int4&) const = default;
};

struct Uint2 {
  uint32_t x = 0, y = 0;
  bool operator==(const Uint2&) const = default;
};

/// Rotation; identity by default.
struct Quaternion {
  float x = 0, y = 0, z = 0, w = 1;
  bool operator==(const Quaternion&) const = default;
};

/// Affine map p -> M p + t, stored as the three rows of [M | t]; identity by default.
struct AffineTransform {
  Float4 rows[3] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  bool operator==(const AffineTransform&) const = default;
};

/// Projective map stored as four rows: clip = rows * (p, 1); identity by default.
struct Matrix4 {
  Float4 rows[4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  bool operator==(const Matrix4&) const = default;
};

}  // namespace pelage
