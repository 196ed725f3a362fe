// Collision meshes from a skinned mesh: as a whole or in pieces, each for its own SDF.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pelage/authoring/skinned_mesh.h"
#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage {

enum class CollisionSplit : uint8_t {
  kWhole,     ///< one mesh
  kMaterial,  ///< one per material
  kPart,      ///< one per object (SkinnedMeshPart::name)
  /// One per bone: the triangles whose weights, summed over the corners, are largest for it.
  kBone,
};

struct CollisionMeshDef {
  CollisionSplit by = CollisionSplit::kWhole;
  /// Names of the materials, objects or bones to use; of the objects for kWhole. Empty means all.
  std::vector<std::string> only;
  /// Closes the holes that splitting cuts into a closed surface, each with a fan of triangles
  /// around its center, so that an SDF can tell inside from outside. Holes of the original mesh
  /// stay.
  bool capHoles = true;
  /// Maximum distance [m] of any point of the result from its piece of the mesh, and vice versa; 0
  /// keeps all triangles. Caps and the rims of capped holes do not change.
  float errorBound = 0;
};

struct NamedCollisionMesh {
  std::string name;  ///< name of the material, object or bone; of the first object for kWhole
  /// Vertices that agree in position and bones are merged; with simplification, those that agree in
  /// position. Bones that no vertex follows are left out.
  CollisionMesh mesh;
  MeshReport report;
  uint32_t sourceTriangleCount = 0;  ///< before simplification, caps included
  uint32_t capCount = 0;             ///< holes closed
  /// Two-sided Hausdorff distance of the simplified surface from the original [m]: an upper bound,
  /// too large by at most 5 % of CollisionMeshDef::errorBound unless the mesh is huge. 0 without
  /// simplification.
  float error = 0;
};

/// Splits a mesh. Materials and objects come in the order of the file, bones in that of
/// SkinnedMesh::bones. A closed piece stays closed when it is simplified. Errors: a mesh that
/// validate() refuses, a name of `only` that the mesh does not have (or a bone that no triangle
/// follows), an error bound that is negative or not finite.
Result<std::vector<NamedCollisionMesh>> collisionMeshes(const SkinnedMesh& mesh,
                                                        const CollisionMeshDef& def = {});

}  // namespace pelage
