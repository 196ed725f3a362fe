// A skinned triangle mesh that hair collides with, and its text file, .tfxmesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

struct CollisionMesh {
  std::vector<BoneName> bones;
  std::vector<Float3> positions;           ///< [vertex] bind pose [m]
  std::vector<Float3> normals;             ///< [vertex] as the file has them, not normalised
  std::vector<BoneInfluences> influences;  ///< [vertex]
  /// Three a triangle, counter-clockwise seen from outside. Degenerate triangles are kept.
  std::vector<uint32_t> indices;
  /// Vertices without weights when the file was loaded; they follow their first bone.
  uint32_t repairedVertexCount = 0;
};

/// Loads a .tfxmesh file (see saveTfxMesh() for its form). Lines may end in LF or CR LF, vertices
/// and triangles may come in any order. Errors name file:line: a number that cannot be read, is not
/// finite or beyond +-1e6, an index out of range or given twice, a missing line, a section that is
/// missing, text after the last triangle.
Result<CollisionMesh> loadTfxMesh(const std::filesystem::path& path);
/// The same from memory; `name` is what errors call it.
Result<CollisionMesh> loadTfxMesh(std::string_view text, std::string_view name);

/// The text of a .tfxmesh file: `numOfBones N` and N lines `index name`; `numOfVertices N` and N
/// lines `index x y z nx ny nz b0 b1 b2 b3 w0 w1 w2 w3`; `numOfTriangles N` and N lines
/// `index v0 v1 v2`; lines that start with # are comments. Numbers are the shortest that read back
/// to the same bits.
Result<std::string> saveTfxMesh(const CollisionMesh& mesh);
Result<void> saveTfxMesh(const CollisionMesh& mesh, const std::filesystem::path& path);

}  // namespace pelage
