// Simple bodies as distance functions, and how they blend. Distances [m] are negative inside, exact
// at the surface and approximate elsewhere.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/portable_math.h"
#include "base/vector3.h"

namespace pelage::detail {

using Vector = Vector3<double>;

// Distances and smooth blends after I. Quilez, "Distance functions" and "Smooth minimum" (2013).
inline double sphere(const Vector& p, const Vector& center, double radius) {
  return length(p - center) - radius;
}

inline double ellipsoid(const Vector& p, const Vector& center, const Vector& radii) {
  const Vector q = p - center;
  const double k0 = length(Vector{q.x / radii.x, q.y / radii.y, q.z / radii.z});
  const double k1 = length(
      Vector{q.x / (radii.x * radii.x), q.y / (radii.y * radii.y), q.z / (radii.z * radii.z)});
  // At the center both are 0; the nearest point is on the shortest axis.
  return k1 > 1e-9 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

/// A capsule whose radius changes from a to b.
inline double taperedCapsule(const Vector& p, const Vector& a, const Vector& b, double radiusA,
                             double radiusB) {
  const Vector axis = b - a;
  const double t = saturate(dot(p - a, axis) / dot(axis, axis));
  return length(p - (a + axis * t)) - (radiusA + (radiusB - radiusA) * t);
}

/// A tapered capsule that knows when it is far away.
class BoundedCapsule {
 public:
  BoundedCapsule(const Vector& a, const Vector& b, double radiusA, double radiusB)
      : a_(a),
        axis_(b - a),
        middle_((a + b) * 0.5),
        radiusA_(radiusA),
        growth_(radiusB - radiusA),
        reach_(0.5 * length(b - a) + std::max(radiusA, radiusB) + kMargin) {}

  double distance(const Vector& p) const {
    const double t = saturate(dot(p - a_, axis_) / dot(axis_, axis_));
    return length(p - (a_ + axis_ * t)) - (radiusA_ + growth_ * t);
  }
  /// True only if distance() is at least this.
  bool isBeyond(const Vector& p, double least) const {
    const double needed = least + reach_;
    const Vector q = p - middle_;
    return needed <= 0 || dot(q, q) > needed * needed;
  }

 private:
  static constexpr double kMargin = 1e-9;  // for rounding
  Vector a_, axis_, middle_;
  double radiusA_, growth_, reach_;
};

/// An ellipsoid, likewise. With q from its center, ellipsoid() is k0 (k0 - 1) / k1 with k0 >= |q| /
/// the longest radius and k1 <= k0 / the shortest.
class BoundedEllipsoid {
 public:
  BoundedEllipsoid(const Vector& center, const Vector& radii)
      : center_(center),
        radii_(radii),
        longest_(std::max({radii.x, radii.y, radii.z})),
        inverseShortest_(1 / std::min({radii.x, radii.y, radii.z})) {}

  double distance(const Vector& p) const { return ellipsoid(p, center_, radii_); }
  /// True only if distance() is at least this.
  bool isBeyond(const Vector& p, double least) const {
    if (!(least > 0)) return false;
    const double needed = longest_ * (least * inverseShortest_ + 1 + kMargin);
    const Vector q = p - center_;
    return dot(q, q) > needed * needed;
  }

 private:
  static constexpr double kMargin = 1e-9;  // for rounding
  Vector center_, radii_;
  double longest_, inverseShortest_;
};

inline double smoothUnion(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width / 4;
}

inline double smoothCut(double body, double hole, double width) {
  return -smoothUnion(-body, hole, width);
}

/// Unit vector along which a distance function grows: differences along the four directions of a
/// tetrahedron.
template <class Distance>
Vector gradientOf(const Vector& p, const Distance& distance) {
  constexpr double kStep = 1e-5;
  Vector sum;
  for (const Vector& k : {Vector{1, -1, -1}, Vector{-1, -1, 1}, Vector{-1, 1, -1}, Vector{1, 1, 1}})
    sum += k * distance(p + k * kStep);
  return normalizeOr(sum, Vector{0, 1, 0});
}

}  // namespace pelage::detail
