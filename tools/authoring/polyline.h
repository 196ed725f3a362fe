// Polylines in double precision: arc length, and the distance of two of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "points.h"

namespace pelage::detail {

/// Squared distance of a point from the segment a b, which may have no length.
double squaredDistance(const Vector& p, const Vector& a, const Vector& b);

/// A point on a polyline: on segment `segment`, at `share` of its length.
struct PolylinePoint {
  size_t segment = 0;
  double share = 0;
};

/// Arc length [point] from the first point; `points` has 2 or more.
std::vector<double> arcLengths(std::span<const Vector> points);

/// The point at an arc length; those beyond the ends are at the ends. `arc` is arcLengths().
PolylinePoint positionAt(std::span<const double> arc, double length);

inline Vector pointAt(std::span<const Vector> points, const PolylinePoint& point) {
  return lerp(points[point.segment], points[point.segment + 1], point.share);
}

/// Answers how far points are from a polyline: boxes around runs of segments, in a binary tree.
class PolylineTree {
 public:
  explicit PolylineTree(std::span<const Vector> points);

  /// The least d^2 such that one segment is within d of both p and q, and so of all points
  /// between them. With p = q the squared distance of p. `hint` is a segment that may be near;
  /// the one that was found replaces it.
  double squaredRange(const Vector& p, const Vector& q, size_t& hint) const;

 private:
  struct Box {
    Vector low, high;
  };
  static double squaredDistance(const Vector& p, const Box& box);

  static constexpr size_t kLeafSize = 8;
  std::span<const Vector> points_;
  size_t leafCount_ = 1;    // a power of two
  std::vector<Box> boxes_;  // node n has children 2n and 2n + 1; the root is 1
};

/// Largest distance of a point of the polyline `from`, vertex or not, to the polyline `to`; at most
/// `tolerance` (> 0) too small.
double maxDistance(std::span<const Vector> from, const PolylineTree& to, double tolerance);

/// Hausdorff distance of two polylines; at most 2^-30 of their size too small.
double hausdorffDistance(std::span<const Vector> a, std::span<const Vector> b);

}  // namespace pelage::detail
