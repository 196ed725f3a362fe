// The mesh that a point cache moves, and the roots on it.
#pragma once

#include <filesystem>
#include <string>

#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/skin_table.h"

namespace pelage::bake {

/// Loads an .obj or .tfxmesh file with its vertices in the order of the file, and gives vertex i
/// the bone i alone. Of .obj files, positions and faces are read; faces are split from their first
/// corner. (assimp, which reads other meshes, does not keep the vertices of an .obj file.)
/// \param scale  meters per unit. Errors: those of loadTfxMesh(); of .obj files, with the line: a
/// coordinate that is not finite or beyond +-1e6, a face with fewer than three corners or one that
/// is no vertex before it, no faces.
Result<CollisionMesh> loadSkinMesh(const std::filesystem::path& path, float scale);

/// The same of the text of an .obj file; `name` names it in errors.
Result<CollisionMesh> readObjMesh(std::string_view text, std::string_view name);

/// Finds each strand's root on a mesh. \param warning  receives a line where roots are farther than
/// 5 mm from it. Errors: those of bindRoots().
Result<SkinTable> bindToSkin(const HairAsset& hair, const CollisionMesh& mesh,
                             std::string& warning);

}  // namespace pelage::bake
