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
/// the bone i alone. \param scale  meters per unit. Errors: those of readObjMesh() and
/// loadTfxMesh().
Result<CollisionMesh> loadSkinMesh(const std::filesystem::path& path, float scale);

/// Finds each strand's root on a mesh. \param warning  receives a line where roots are farther than
/// 5 mm from it. Errors: those of bindRoots().
Result<SkinTable> bindToSkin(const HairAsset& hair, const CollisionMesh& mesh,
                             std::string& warning);

}  // namespace pelage::bake
