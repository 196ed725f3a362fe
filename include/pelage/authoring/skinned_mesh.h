// A mesh with bones as its file has it: what hair is bound to, and what collision meshes are cut
// from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/authoring/curve_import.h"
#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// One mesh of a file at one of its nodes; it has one material. Its vertices and triangles are
/// neighbours in the arrays of SkinnedMesh.
struct SkinnedMeshPart {
  std::string name;  ///< of the node: the object of modelling programs
  std::string mesh;  ///< of the mesh; empty for a .tfxmesh file
  std::string material;
  uint32_t firstVertex = 0, vertexCount = 0;
  uint32_t firstTriangle = 0, triangleCount = 0;
  bool operator==(const SkinnedMeshPart&) const = default;
};

struct SkinnedMesh {
  std::vector<SkinnedMeshPart> parts;  ///< in order, without gaps
  std::vector<BoneName> bones;         ///< each index below the bone count once
  /// [vertex] in the scene of the file, in the pose that the file has; the file's unit. Vertices of
  /// a part are in the file's order and not merged, so that those of an engine are found again.
  std::vector<Float3> positions;
  std::vector<Float3> normals;  ///< [vertex] zero where the file has none
  /// [vertex] the four heaviest bones, heaviest first; weights sum to 1. Places that are not needed
  /// have the heaviest bone and the weight 0.
  std::vector<BoneInfluences> influences;
  /// Three a triangle, counter-clockwise seen from outside; vertices of the whole, not of the part.
  std::vector<uint32_t> indices;
  /// Vertices of skinned meshes that have no weights; they follow their node.
  uint32_t repairedVertexCount = 0;

  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
};

/// Loads all triangles of any file that assimp reads (glTF, FBX, OBJ, ...), polygons split, or a
/// .tfxmesh file, which is one part named after the file. In the library pelage::mesh_import.
/// - Vertices are where the file's nodes put them: those of skinned meshes by their bones, the
///   others by their node.
/// - What has no weights follows its node, as a bone of that name.
/// - glTF keeps its vertices; formats with separate indices for normals and texture coordinates
///   (OBJ, FBX) come with one vertex a corner, face by face.
/// Errors as loadMesh().
Result<SkinnedMesh> loadSkinnedMesh(const std::filesystem::path& path);

/// How prepareMesh() changes a mesh, in this order; as CurveImportDef does for hair.
struct MeshImportDef {
  float scale = 1;             ///< metres a unit of the file, 1e-9..1e9
  UpAxis upAxis = UpAxis::kY;  ///< of the file
  bool invertZ = false;        ///< z -> -z, after the turn; triangles are turned round with it
  bool operator==(const MeshImportDef&) const = default;
};

/// Changes positions and normals, so that the mesh is where the hair is. Errors: a scale out of
/// range, what validate() refuses, before or after (a coordinate beyond kMaxCoordinate).
Result<void> prepareMesh(SkinnedMesh& mesh, const MeshImportDef& def);

/// Checks that the arrays fit together and the values are in range: coordinates finite and within
/// kMaxCoordinate, weights 0 to 1e6 with a sum above 0. Errors name part, vertex or triangle.
Result<void> validate(const SkinnedMesh& mesh);

}  // namespace pelage
