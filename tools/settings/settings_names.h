// Names of settings in files and in errors.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "pelage/settings/scene_settings.h"

namespace pelage::settings {

/// "simulation.wind.velocity", "lights[0].color".
inline std::string nameOf(const SettingsSection& section, size_t index, std::string_view path) {
  std::string name(section.key);
  if (section.isList) name += '[' + std::to_string(index) + ']';
  return name + '.' + std::string(path);
}

}  // namespace pelage::settings
