// Files of modeling programs, read by the authoring library: hair curves, and characters that hair
// collides with and follows. A build without the library knows no such files.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "demo_scene.h"
#include "pelage/result.h"

namespace sample {

/// Whether this build reads files of an extension (".hair", in lower case) as hair, or looks for
/// hair, meshes, skins and clips in them.
bool isModelingFile(std::string_view extension);
/// Returns ", .hair, ..." for messages; empty without the authoring library.
const char* modelingExtensions();

struct ModelingDef {
  float scale = 1;        ///< meters per unit of all files
  std::string clip = {};  ///< name; the first one if empty
};
/// Adds the contents of files: their curves as hair, resampled and processed, with colors and
/// thickness; their triangles as colliders, which hair without bones follows; and a clip, unless
/// there is a motion already. Files of hair alone come first. \param remarks receives a line for
/// all that was assumed or left out. Errors: those of the authoring library; a file with neither
/// curves nor triangles; a clip that does not exist; a build without the authoring library.
pelage::Result<void> addModelingFiles(std::span<const std::filesystem::path> paths,
                                      const ModelingDef& def, FileAssets& files,
                                      std::vector<std::string>& remarks);

/// Loads a clip of a glTF file. Errors: those of pelage::loadAnimation(); a build without the
/// authoring library.
pelage::Result<BoneMotion> loadMotion(const std::filesystem::path& path, const ModelingDef& def);

}  // namespace sample
