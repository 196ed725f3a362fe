// Kinds of hair as settings, to begin with.
#pragma once

#include <span>
#include <string_view>

#include "pelage/result.h"
#include "pelage/settings/settings_file.h"

namespace pelage {

/// A kind of hair: simulation, material and follow hairs.
struct SettingsPreset {
  std::string_view name;     ///< "curly"
  std::string_view meaning;  ///< a sentence
  std::string_view text;     ///< JSON of SettingsFile
};

/// long, curly, fur, mohawk, afro and beard.
std::span<const SettingsPreset> settingsPresets();

/// Settings of a preset; what it does not set has its default. Error: there is none of this name,
/// with the names that there are.
Result<SceneSettings> presetSettings(std::string_view name);

}  // namespace pelage
