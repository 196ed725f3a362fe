// Closest points on a set of triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"
#include "points.h"

namespace pelage::detail {

/// A point of a triangle set.
struct SurfacePoint {
  uint32_t triangle = 0;
  std::array<double, 3> barycentric{};  ///< 0..1, the sum is 1
  Vector position;
  double squaredDistance = 0;
};

/// Closest point of one triangle; one without area is the segments between its corners. Points of
/// an edge or a corner come out the same to the last bit for all triangles that share it. Does not
/// set SurfacePoint::triangle.
SurfacePoint closestPoint(const Vector& point, const std::array<Vector, 3>& triangle);

/// A tree of boxes over triangles, for exact searches of the closest point.
class TriangleTree {
 public:
  /// \param positions  [vertex], finite, within kMaxCoordinate
  /// \param indices    three vertices a triangle
  /// \param used       triangles to be searched; at least one
  TriangleTree(std::span<const Float3> positions, std::span<const uint32_t> indices,
               std::vector<uint32_t> used);

  /// The closest point; among equally close ones that on the lowest triangle. `hint` is a triangle
  /// that may be near; it makes the search shorter and does not change the result.
  SurfacePoint closest(const Vector& point, uint32_t hint) const;
  SurfacePoint closest(const Vector& point) const { return closest(point, used_[0]); }

  std::array<Vector, 3> corners(uint32_t triangle) const;

 private:
  struct Node {
    Vector low, high;
    uint32_t first = 0;  ///< of a leaf: into used_; else its second child (the first one follows)
    uint32_t count = 0;  ///< of a leaf's triangles; 0 = not a leaf
  };
  void build(uint32_t first, uint32_t count, const std::vector<Vector>& centers);

  std::span<const Float3> positions_;
  std::span<const uint32_t> indices_;
  std::vector<uint32_t> used_;
  std::vector<Node> nodes_;
};

}  // namespace pelage::detail
