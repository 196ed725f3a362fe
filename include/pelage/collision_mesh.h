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
#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

namespace detail {
struct PreparedCollider;
}

/// A mesh that hair collides with. Threads: as a standard container: several threads and scenes may
/// read one while none writes.
struct CollisionMesh {
  std::vector<BoneName> bones;
  std::vector<Float3> positions;           ///< [vertex] bind pose [m]
  std::vector<Float3> normals;             ///< [vertex] as in the file, not normalized
  std::vector<BoneInfluences> influences;  ///< [vertex]
  /// Three per triangle, counter-clockwise seen from outside. Degenerate triangles are kept.
  std::vector<uint32_t> indices;
  /// Number of vertices without weights in the loaded file; they follow their first bone.
  uint32_t repairedVertexCount = 0;
  /// Set by prepareCollider() and by caches; copies of the mesh share it.
  std::shared_ptr<const detail::PreparedCollider> prepared;
};

/// Computes in advance what Scene::addCollider() otherwise computes: the neighbors of triangles,
/// and the vertices with equal positions. The result depends only on positions and indices; if
/// these change, addCollider() notices and ignores it. Caches store it. Errors: indices that are no
/// triangles or refer to vertices that do not exist.
PELAGE_API Result<void> prepareCollider(CollisionMesh& mesh);

/// Loads a .tfxmesh file (docs/assets_formats.md). Lines may end in LF or CR LF; vertices and
/// triangles may come in any order. Errors name file:line: a number that cannot be read, is not
/// finite or beyond +-1e6, an index out of range or given twice, a missing line or section, text
/// after the last triangle.
PELAGE_API Result<CollisionMesh> loadTfxMesh(const std::filesystem::path& path);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<CollisionMesh> loadTfxMesh(std::string_view text, std::string_view name);
PELAGE_API Result<CollisionMesh> loadTfxMesh(ByteSource& source, std::string_view name);

/// Returns the text of a .tfxmesh file: `numOfBones N` and N lines `index name`; `numOfVertices N`
/// and N lines `index x y z nx ny nz b0 b1 b2 b3 w0 w1 w2 w3`; `numOfTriangles N` and N lines
/// `index v0 v1 v2`; lines that start with # are comments. Numbers are the shortest that read back
/// to the same bits.
PELAGE_API Result<std::string> saveTfxMesh(const CollisionMesh& mesh);
PELAGE_API Result<void> saveTfxMesh(const CollisionMesh& mesh, const std::filesystem::path& path);

/// The properties of a mesh as a surface. Vertices with equal bind positions count as one.
struct MeshReport {
  uint32_t vertexCount = 0;
  uint32_t weldedVertexCount = 0;  ///< distinct positions
  uint32_t triangleCount = 0;
  /// Triangles without duplicates and without those that have two corners at one position.
  uint32_t usedTriangleCount = 0;
  uint32_t nonFiniteVertices = 0;    ///< a coordinate is NaN or infinite
  uint32_t nonFiniteTriangles = 0;   ///< with such a vertex; they are in no SDF
  uint32_t degenerateTriangles = 0;  ///< without area in the bind pose
  uint32_t duplicateTriangles = 0;   ///< the same positions in the same order as an earlier one
  uint32_t openEdges = 0;            ///< edges with one triangle
  uint32_t nonManifoldEdges = 0;     ///< edges with more than two triangles
  uint32_t misorientedEdges = 0;     ///< edges whose triangles do not use it in opposite directions
  double volume = 0;                 ///< signed [m3]: negative if the mesh is inside out
  /// No edge has an odd number of triangles, and all triangles are finite.
  bool closed = false;
  bool consistentlyOriented = false;  ///< no misoriented edge
  bool inverted = false;              ///< closed, consistently oriented, negative volume

  bool operator==(const MeshReport&) const = default;
};

/// Inspects a mesh. Error: indices that are no triangles or refer to vertices that do not exist.
PELAGE_API Result<MeshReport> inspectMesh(const CollisionMesh& mesh);

/// Returns one line: the counts, and what they mean for an SDF.
PELAGE_API std::string describe(const MeshReport& report);

}  // namespace pelage
