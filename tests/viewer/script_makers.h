// Scripts for the viewer that nobody would write by hand: every setting once, every method, input
// at random.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/settings/scene_settings.h"

namespace pelage::test {

/// Writes files of settings into a folder, of which a script drops one a frame: in each of them one
/// parameter of what the window has is three quarters up its slider, and the others are those of
/// `base`. The last frame has `base` again.
/// \param sections  bit i: the i-th of settingsSections().
std::string everySetting(const SceneSettings& base, uint32_t sections,
                         const std::filesystem::path& folder);

/// The same for all methods of transparency and kinds of shadow. Of each method there is a
/// screenshot "method_NAME.png", and "view.png" of a target with 4 samples and reversed depth.
/// \param names  gets the NAMEs.
std::string everyMethod(const SceneSettings& base, const std::filesystem::path& folder,
                        std::vector<std::string>& names);

/// Random mouse, keys, wheel, sizes of the window, and drops of `files`, for so many frames. Equal
/// seeds make equal scripts.
std::string randomInput(uint32_t seed, uint32_t frames, const std::vector<std::string>& files);

/// Writes a file of settings with random values within their sliders, which a slow driver draws
/// within seconds, too. \return its name.
std::string randomSettingsFile(const SceneSettings& base, uint32_t seed,
                               const std::filesystem::path& folder);

}  // namespace pelage::test
