// The topology of a collider's triangles: computed once, from the bind pose, and valid for any
// later pose.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/collision_mesh.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::detail {

struct ColliderTopology {
  static constexpr uint32_t kNone = 0xffffffffu;

  /// Three vertices of the mesh per triangle; triangle indices here refer to this array. It leaves
  /// out triangles with two corners at one position, and duplicates. Triangles of an inverted mesh
  /// are flipped.
  std::vector<uint32_t> indices;
  std::vector<uint32_t> sourceTriangles;  ///< [triangle] its index in the mesh
  /// Three per triangle, across the edges 01, 12, 20; kNone if the edge does not have exactly two
  /// triangles.
  std::vector<uint32_t> adjacency;

  std::vector<uint32_t> weldedVertices;  ///< [vertex of the mesh] its point
  std::vector<uint32_t> pointVertices;   ///< [point] the first vertex of the mesh that is there
  /// The corners at point p are pointCorners[pointOffsets[p] .. pointOffsets[p + 1]), ascending:
  /// corner c is that of indices[c], of triangle c / 3.
  std::vector<uint32_t> pointOffsets;
  std::vector<uint32_t> pointCorners;

  MeshReport report;

  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
  uint32_t pointCount() const { return static_cast<uint32_t>(pointVertices.size()); }
  /// True if crossings along any one axis tell inside from outside.
  bool isSolid() const { return report.closed && report.consistentlyOriented; }
};

/// \param vertexCount    of the mesh
/// \param bindPositions  [vertex]; empty when they are not known: every vertex is a point of its
///                       own, and nothing is said about areas, volume and orientation
/// Errors: an index that is out of range, a number of indices that is no multiple of 3, positions
/// of another number than vertices, 2^30 triangles or more.
Result<ColliderTopology> makeColliderTopology(std::span<const uint32_t> indices,
                                              uint32_t vertexCount,
                                              std::span<const Float3> bindPositions);

}  // namespace pelage::detail
