// An orthonormal frame on a triangle.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/vector3.h"
#include "pelage/types.h"

namespace pelage::detail {

struct TriangleFrame {
  Vector3<double> x, y, z;  ///< unit: edge 01, z cross x, normal
  /// Corner 1 is at (edge, 0) and corner 2 at (shear, height) in the plane; edge, height > 0 [m].
  double edge = 0, shear = 0, height = 0;

  Vector3<double> toSpace(const Vector3<double>& v) const { return x * v.x + y * v.y + z * v.z; }
};

/// Returns nothing if the triangle is not finite or has no area (twice the area over the square of
/// its longest edge is below the rounding of three collinear points in float).
inline std::optional<TriangleFrame> triangleFrame(const Vector3<double>& a,
                                                  const Vector3<double>& b,
                                                  const Vector3<double>& c) {
  constexpr double kNoArea = 1e-9;
  const Vector3<double> u = b - a, v = c - a, w = c - b;
  const Vector3<double> normal = cross(u, v);
  const double area = length(normal), edge = length(u);
  const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
  if (!(area > kNoArea * longest) || !std::isfinite(area)) return std::nullopt;
  TriangleFrame frame;
  frame.edge = edge;
  frame.x = u * (1 / edge);
  frame.z = normal * (1 / area);
  frame.y = cross(frame.z, frame.x);
  frame.shear = dot(v, frame.x);
  frame.height = area / edge;
  return frame;
}

}  // namespace pelage::detail
