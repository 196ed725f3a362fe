// Meshes of .obj files with their vertices in the order of the file.
#pragma once

#include <string_view>

#include "pelage/collision_mesh.h"
#include "pelage/result.h"

namespace pelage::bake {

/// Reads the positions and faces of an .obj file; faces are split from their first corner. The mesh
/// has no bones. (assimp, which reads other meshes, does not keep the vertices of an .obj file.)
/// \param name  names the text in errors, which have the line: a coordinate that is not finite or
/// beyond +-1e6, a face with fewer than three corners or one that is no vertex before it, no faces.
Result<CollisionMesh> readObjMesh(std::string_view text, std::string_view name);

}  // namespace pelage::bake
