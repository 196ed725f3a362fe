// A skinned triangle mesh that hair collides with, and its text file, .tfxmesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
struct PreparedCollider;
}

struct CollisionMesh {
  std::vector<BoneName> bones;
  std::vector<Float3> positions;           ///< [vertex] bind pose [m]
  std::vector<Float3> normals;             ///< [vertex] as the file has them, not normalised
  std::vector<BoneInfluences> influences;  ///< [vertex]
  /// Three a triangle, counter-clockwise seen from outside. Degenerate triangles are kept.
  std::vector<uint32_t> indices;
  /// Vertices without weights when the file was loaded; they follow their first bone.
  uint32_t repairedVertexCount = 0;
  /// Set by prepareCollider() and by caches; copies of the mesh share it.
  std::shared_ptr<const detail::PreparedCollider> prepared;
};

/// Finds out now what Scene::addCollider() else does on the spot: which triangles are neighbours,
/// which vertices are in one place. It depends on positions and indices alone; when these change,
/// addCollider() notices and does without. Caches keep it. Errors: indices that are no triangles or
/// refer to vertices that are not there.
Result<void> prepareCollider(CollisionMesh& mesh);

/// Loads a .tfxmesh file (see saveTfxMesh() for its form). Lines may end in LF or CR LF, vertices
/// and triangles may come in any order. Errors name file:line: a number that cannot be read, is not
/// finite or beyond +-1e6, an index out of range or given twice, a missing line, a section that is
/// missing, text after the last triangle.
Result<CollisionMesh> loadTfxMesh(const std::filesystem::path& path);
/// The same from memory, or from a stream, all of which is read at once; `name` is what errors call
/// it.
Result<CollisionMesh> loadTfxMesh(std::string_view text, std::string_view name);
Result<CollisionMesh> loadTfxMesh(ByteSource& source, std::string_view name);

/// The text of a .tfxmesh file: `numOfBones N` and N lines `index name`; `numOfVertices N` and N
/// lines `index x y z nx ny nz b0 b1 b2 b3 w0 w1 w2 w3`; `numOfTriangles N` and N lines
/// `index v0 v1 v2`; lines that start with # are comments. Numbers are the shortest that read back
/// to the same bits.
Result<std::string> saveTfxMesh(const CollisionMesh& mesh);
Result<void> saveTfxMesh(const CollisionMesh& mesh, const std::filesystem::path& path);

/// What a mesh is like as a surface. Vertices at the same place in the bind pose count as one.
struct MeshReport {
  uint32_t vertexCount = 0;
  uint32_t weldedVertexCount = 0;  ///< places
  uint32_t triangleCount = 0;
  /// Without those that have two corners at one place and without duplicates.
  uint32_t usedTriangleCount = 0;
  uint32_t nonFiniteVertices = 0;    ///< a coordinate is NaN or infinite
  uint32_t nonFiniteTriangles = 0;   ///< with such a vertex; they are in no field
  uint32_t degenerateTriangles = 0;  ///< without area in the bind pose
  uint32_t duplicateTriangles = 0;   ///< same places in the same order as an earlier one
  uint32_t openEdges = 0;            ///< with one triangle
  uint32_t nonManifoldEdges = 0;     ///< with more than two
  uint32_t misorientedEdges = 0;     ///< whose triangles do not run along it in opposite directions
  double volume = 0;                 ///< [m3], signed: negative when the inside is outside
  /// No edge has an odd number of triangles, and none of the triangles is not finite.
  bool closed = false;
  bool consistentlyOriented = false;  ///< no misoriented edge
  bool inverted = false;              ///< closed, consistently oriented, negative volume

  bool operator==(const MeshReport&) const = default;
};

/// Judges a mesh. Error: indices that are no triangles or refer to vertices that are not there.
Result<MeshReport> inspectMesh(const CollisionMesh& mesh);

/// One line: the counts, and what they mean for a distance field.
std::string describe(const MeshReport& report);

}  // namespace pelage
