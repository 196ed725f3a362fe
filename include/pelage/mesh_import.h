// Loads collision meshes from the formats of modeling programs. In the library pelage::mesh_import,
// which exists if pelage was built with assimp (PELAGE_MESH_IMPORT).
#pragma once

#include <filesystem>

#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage {

/// Loads all triangles of any file that assimp reads (glTF, FBX, OBJ, ...); polygons are split.
/// Calls loadTfxMesh() for a .tfxmesh file.
/// - Vertices are posed by the file's nodes: those of skinned meshes by their bones, in the pose of
///   the file, the others by their node. Units are those of the file.
/// - A vertex has its four strongest bones; their weights sum to 1. A vertex without weights
///   follows its node, as a bone with the name of the node; in a skinned mesh it counts as
///   repaired.
/// - Vertices that agree in position, normal and bones are merged.
///
/// loadSkinnedMesh() of pelage/authoring/skinned_mesh.h keeps objects and materials separate.
/// Errors name the file, and the mesh if there is one: a file that does not exist or cannot be
/// read, no triangles, a coordinate that is not finite or beyond +-1e6, an index out of range.
Result<CollisionMesh> loadMesh(const std::filesystem::path& path);

}  // namespace pelage
