// Collision meshes out of a skinned mesh: as a whole or in pieces, each for a distance field of its
// own.
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
  kMaterial,  ///< one a material
  kPart,      ///< one an object (SkinnedMeshPart::name)
  /// One a bone: the triangles whose weights, summed over the corners, are largest for it.
  kBone,
};

struct CollisionMeshDef {
  CollisionSplit by = CollisionSplit::kWhole;
  /// Names of the materials, objects or bones to take; of the objects for kWhole. Empty for all.
  std::vector<std::string> only;
  /// Closes the holes that splitting cuts into a closed surface, each with a fan of triangles
  /// around its middle, so that a distance field knows inside from outside. Holes that the file
  /// has stay.
  bool capHoles = true;
  /// Largest distance [m] of any point of the result from the piece of the mesh it comes from, and
  /// the other way round; 0 keeps all triangles. The rims of capped holes and the caps stay as they
  /// are.
  float errorBound = 0;
};

struct NamedCollisionMesh {
  std::string name;  ///< of the material, object or bone; of the first object for kWhole
  /// Vertices that agree in position and bones are one, with simplification those that agree in
  /// position. Bones that no vertex follows are left out.
  CollisionMesh mesh;
  MeshReport report;
  uint32_t sourceTriangleCount = 0;  ///< before simplification, caps included
  uint32_t capCount = 0;             ///< holes closed
  /// Two-sided Hausdorff distance of the simplified surface from the original [m]: an upper bound,
  /// by at most 5 % of CollisionMeshDef::errorBound too large unless the mesh is huge. 0 without
  /// simplification.
  float error = 0;
};

/// Takes a mesh apart. Materials and objects come in the order of the file, bones in that of
/// SkinnedMesh::bones. A closed piece stays closed when it is simplified.
/// Errors: a mesh that validate() refuses, a name of `only` that the mesh does not have (or that no
/// triangle follows, for a bone), an error bound that is negative or not finite.
Result<std::vector<NamedCollisionMesh>> collisionMeshes(const SkinnedMesh& mesh,
                                                        const CollisionMeshDef& def = {});

}  // namespace pelage
