// The character as a glTF 2.0 file, for modelling programs.
#pragma once

#include <filesystem>

#include "pelage/demo/character.h"
#include "pelage/result.h"

namespace sample {

/// Writes `path` (.gltf) and a .bin file beside it: the mesh with a material for each part, the
/// skin, and the animations "walk" (one stride that repeats), "headShake" and "jump" at 30 Hz.
/// Errors: a file that cannot be written.
pelage::Result<void> writeGltf(const pelage::Character& character,
                               const std::filesystem::path& path);

}  // namespace sample
