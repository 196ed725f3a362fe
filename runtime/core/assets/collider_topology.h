// What the triangles of a collider have to do with each other: found once, from the bind pose, for
// any pose later.
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

  /// Three vertices of the mesh a triangle; triangles here are counted by these. Missing are those
  /// with two corners at one place, and duplicates. Those of an inverted mesh are turned round.
  std::vector<uint32_t> indices;
  std::vector<uint32_t> sourceTriangles;  ///< [triangle] its number in the mesh
  /// Three a triangle, across the edges 01, 12, 20; kNone where the edge has not just two
  /// triangles.
  std::vector<uint32_t> adjacency;

  std::vector<uint32_t> weldedVertices;  ///< [vertex of the mesh] its place
  std::vector<uint32_t> placeVertices;   ///< [place] the first vertex of the mesh that is there
  /// The corners at place p are placeCorners[placeOffsets[p] .. placeOffsets[p + 1]), ascending:
  /// corner c is that of indices[c], of triangle c / 3.
  std::vector<uint32_t> placeOffsets;
  std::vector<uint32_t> placeCorners;

  MeshReport report;

  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
  uint32_t placeCount() const { return static_cast<uint32_t>(placeVertices.size()); }
  /// Whether crossings along any one axis tell inside from outside.
  bool isSolid() const { return report.closed && report.consistentlyOriented; }
};

/// \param vertexCount    of the mesh
/// \param bindPositions  [vertex]; empty when they are not known: every vertex is a place of its
///                       own, and nothing is said about areas, volume and orientation
/// Errors: an index that is out of range, a number of indices that is no multiple of 3, positions
/// of another number than vertices, 2^30 triangles or more.
Result<ColliderTopology> makeColliderTopology(std::span<const uint32_t> indices,
                                              uint32_t vertexCount,
                                              std::span<const Float3> bindPositions);

}  // namespace pelage::detail
