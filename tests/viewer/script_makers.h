// Makes long scripts for the viewer: every setting once, every method, random input.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/settings/scene_settings.h"

namespace pelage::test {

/// Writes files of settings to a folder, and returns a script that drops one file a frame. Each
/// file has the settings of `base`, but one parameter is at three quarters of its slider. The last
/// frame has `base` again.
std::string everySetting(const SceneSettings& base, const std::filesystem::path& folder);

/// Does the same for all methods of transparency and kinds of shadow. The script saves a screenshot
/// "method_NAME.png" of each method, and "view.png" of a target with 4 samples and reversed depth.
/// \param names receives the NAMEs.
std::string everyMethod(const SceneSettings& base, const std::filesystem::path& folder,
                        std::vector<std::string>& names);

/// Returns a script of random events for a number of frames: mouse, keys, wheel, sizes of the
/// window, and drops of `files`. Equal seeds make equal scripts.
std::string randomInput(uint32_t seed, uint32_t frames, const std::vector<std::string>& files);

/// Writes a file of settings with random values within their sliders. Costly parameters get small
/// values, so that a slow driver draws within seconds. \return its name.
std::string randomSettingsFile(const SceneSettings& base, uint32_t seed,
                               const std::filesystem::path& folder);

}  // namespace pelage::test
