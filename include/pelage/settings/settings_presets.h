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

/// Settings of a preset; values that it does not set have their defaults. Error: no preset has this
/// name; the message lists all names.
Result<SceneSettings> presetSettings(std::string_view name);

}  // namespace pelage
