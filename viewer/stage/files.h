// Grooms and meshes from the files that a user names or drops.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "demo_scene.h"
#include "pelage/asset_cache.h"
#include "pelage/hair_size.h"
#include "pelage/result.h"

namespace viewer {

struct LoadedFiles {
  pelage::AssetCache assets;
  float scale = 1;                           ///< meters per unit of the files
  double meanLength = 0;                     ///< of the strands with the scale [m]
  std::vector<pelage::UnitGuess> guesses;    ///< where the files are not in meters
  std::vector<std::string> remarks;          ///< of the loaders, one a line
  std::optional<sample::BoneMotion> motion;  ///< of the bones: a clip of a file
};

/// Loads files of any kind that the viewer knows, by their extensions: .tfx with .tfxbone and
/// .tfxfollow of the same name (named as well, or beside it), .tfxmesh, .pelage; with the authoring
/// library .hair and .hairtxt, and .gltf, .glb and .obj, whose curves are hair, whose triangles are
/// colliders that hair without bones follows, and whose first clip moves the bones. \param scale
/// meters per unit; 0: found from the size of the hair. \param clip name of the clip. Errors: those
/// of the loaders, another kind of file, no hair, several .pelage.
pelage::Result<LoadedFiles> loadFiles(std::span<const std::filesystem::path> files, float scale,
                                      const std::string& clip = {});

/// Whether loadFiles() takes files with this name, or the viewer settings: .json.
bool isKnownFile(const std::filesystem::path& path);

}  // namespace viewer
