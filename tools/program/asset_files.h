// Grooms and meshes from the files that a command line names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pelage/asset_cache.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace pelage::program {

struct AssetFiles {
  std::vector<std::filesystem::path> hairs = {};  ///< .tfx
  /// .tfxbone and .tfxfollow of the hairs, in the same order; "-" for none.
  std::vector<std::filesystem::path> bones = {}, followHairs = {};
  std::vector<std::filesystem::path> meshes = {};  ///< .tfxmesh
  std::filesystem::path cache = {};                ///< .pelage; its hairs and meshes come first
  float scale = 1;                                 ///< meters per unit of all files
  bool repair = false;                             ///< TfxLoadOptions::repair
  ProcessDef process = {};                         ///< of .tfx files
};

/// Loads all files; hair is processed, and named after its file. \param warnings receives a line
/// for each file of which values were repaired. Errors: those of the loaders, a scale out of range,
/// more `bones` or `followHairs` than `hairs`.
Result<AssetCache> loadAssetFiles(const AssetFiles& files, std::vector<std::string>& warnings);

/// Returns the extension with its dot, in lower case.
std::string lowerExtension(const std::filesystem::path& path);

/// Returns a line for each groom that is too long or too short for meters. \param scale that was
/// given for all files.
std::vector<std::string> unitWarnings(const AssetCache& assets, float scale);
/// Returns "FILE: ..." with the way out, or nothing if hair of this size can be in meters. \param
/// size with the scale. \param scale that was given.
std::string unitWarningOf(const std::filesystem::path& file, const HairSize& size, float scale);

}  // namespace pelage::program
