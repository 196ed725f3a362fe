// Characters of modeling programs: what hair collides with, follows, and how it moves.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "stage/files.h"

namespace viewer {

/// Whether this build looks for meshes, skins and clips in files of an extension (".gltf").
bool isCharacterFile(std::string_view extension);

/// Adds what a file has to the files: curves as hair, else its triangles as a collider, and its
/// clip where there is no motion yet. Hair without bones follows the mesh. Scales of files with
/// several meshes are those of LoadedFiles::scale. \param clip name of the clip; empty: the first
/// one. Errors: a file with neither curves nor triangles; a clip that does not exist; a build
/// without the authoring library.
pelage::Result<void> addCharacterFile(const std::filesystem::path& path, const std::string& clip,
                                      LoadedFiles& files);

}  // namespace viewer
