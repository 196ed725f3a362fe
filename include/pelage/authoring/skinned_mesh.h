// A mesh with bones as in its file: hair is bound to it, and collision meshes are made from it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/authoring/hair_curves.h"
#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// One mesh of a file at one of its nodes, with one material. Its vertices and triangles are
/// contiguous in the arrays of SkinnedMesh.
struct SkinnedMeshPart {
  std::string name;  ///< name of the node: the object of modeling programs
  std::string mesh;  ///< name of the mesh; empty for a .tfxmesh file
  std::string material;
  uint32_t firstVertex = 0, vertexCount = 0;
  uint32_t firstTriangle = 0, triangleCount = 0;
  bool operator==(const SkinnedMeshPart&) const = default;
};

struct SkinnedMesh {
  std::vector<SkinnedMeshPart> parts;  ///< in order, without gaps
  std::vector<BoneName> bones;         ///< each index below the bone count occurs once
  /// [vertex] in the scene of the file, in the pose and the unit of the file. Vertices of a part
  /// are in the file's order and not merged, so that an engine can find them again.
  std::vector<Float3> positions;
  std::vector<Float3> normals;  ///< [vertex] zero if the file has none
  /// [vertex] the four heaviest bones, heaviest first; weights sum to 1. Unused entries have the
  /// heaviest bone and the weight 0.
  std::vector<BoneInfluences> influences;
  /// Three per triangle, counter-clockwise seen from outside; indices into the whole mesh, not into
  /// the part.
  std::vector<uint32_t> indices;
  /// Number of vertices of skinned meshes without weights; they follow their node.
  uint32_t repairedVertexCount = 0;

  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
};

/// Loads all triangles of any file that assimp reads (glTF, FBX, OBJ, ...), with polygons split, or
/// of a .tfxmesh file, which is one part named after the file. In the library pelage::mesh_import.
/// - Vertices are posed by the file's nodes: those of skinned meshes by their bones, the others by
///   their node.
/// - A vertex without weights follows its node, as a bone with the name of the node.
/// - glTF keeps its vertices; formats with separate indices for normals and texture coordinates
///   (OBJ, FBX) give one vertex per corner, face by face.
///
/// Errors: those of loadMesh().
Result<SkinnedMesh> loadSkinnedMesh(const std::filesystem::path& path);

/// The changes of prepareMesh(), in this order; as CurveImportDef for hair.
struct MeshImportDef {
  float scale = 1;             ///< meters per unit of the file, 1e-9..1e9
  UpAxis upAxis = UpAxis::kY;  ///< up axis of the file
  bool invertZ = false;        ///< z -> -z, after the rotation; triangles are flipped with it
  bool operator==(const MeshImportDef&) const = default;
};

/// Transforms positions and normals, so that the mesh is where the hair is. Errors: a scale out of
/// range, and what validate() refuses, before or after (a coordinate beyond kMaxCoordinate).
Result<void> prepareMesh(SkinnedMesh& mesh, const MeshImportDef& def);

/// Checks that the arrays match and the values are in range: coordinates finite and within
/// kMaxCoordinate, weights 0 to 1e6 with a sum above 0. Errors name part, vertex or triangle.
Result<void> validate(const SkinnedMesh& mesh);

}  // namespace pelage
