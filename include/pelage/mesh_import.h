// Collision meshes from the formats of modelling programs. In the library pelage::mesh_import,
// which is there when pelage was built with assimp (PELAGE_MESH_IMPORT).
#pragma once

#include <filesystem>

#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage {

/// Loads all triangles of any file that assimp reads (glTF, FBX, OBJ, ...), polygons split;
/// a .tfxmesh file by loadTfxMesh().
/// - Vertices are where the file's nodes put them: those of skinned meshes by their bones, in the
///   pose that the file has, the others by their node. Units are those of the file.
/// - A vertex has its four strongest bones, their weights summing to 1. What has no weights follows
///   its node, as a bone of that name; in a skinned mesh it counts as repaired.
/// - Vertices that agree in position, normal and bones become one.
/// loadSkinnedMesh() of pelage/authoring/skinned_mesh.h keeps them apart, by objects and materials.
/// Errors name the file, and the mesh where there is one: a file that is not there or cannot be
/// read, no triangles, a coordinate that is not finite or beyond +-1e6, an index out of range.
Result<CollisionMesh> loadMesh(const std::filesystem::path& path);

}  // namespace pelage
