#include "pelage/settings/settings_file.h"

#include <fmt/format.h>

namespace pelage {
namespace {

constexpr SettingsPreset kPresets[] = {
    {"long", "Long straight dark hair that swings.", R"({
  "simulation": {"damping": 0.04, "bendLength": 0.12, "globalStiffness": 0.03, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"rootColor": [0.008, 0.006, 0.005], "tipColor": [0.022, 0.014, 0.011],
               "colorVariation": 0.25, "fiberRadius": 115e-6, "tipRadiusRatio": 0.15,
               "longitudinalRoughness": 0.2},
  "follow": {"countPerGuide": 10, "flyaways": 0.03}
})"},
    {"curly", "Red curls, lit as dielectric fibers are.", R"({
  "simulation": {"damping": 0.04, "bendLength": 0.08, "globalStiffness": 0.1, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"rootColor": [0.06, 0.016, 0.004], "tipColor": [0.2, 0.058, 0.012],
               "colorVariation": 0.25, "fiberRadius": 115e-6, "tipRadiusRatio": 0.15,
               "longitudinalRoughness": 0.35},
  "follow": {"countPerGuide": 10, "maxRadius": 0.003, "flyaways": 0.03}
})"},
    {"fur", "Short dense fur that stands up again.", R"({
  "simulation": {"damping": 0.04, "bendLength": 0.08, "globalStiffness": 0.3, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"rootColor": [0.06, 0.04, 0.022], "tipColor": [0.5, 0.37, 0.2],
               "colorVariation": 0.25, "fiberRadius": 70e-6, "tipRadiusRatio": 0.15,
               "longitudinalRoughness": 0.45},
  "follow": {"countPerGuide": 8, "maxRadius": 0.002, "flyaways": 0.03}
})"},
    {"mohawk", "A stiff red strip that stands.", R"({
  "simulation": {"damping": 0.04, "bendLength": 0.3, "globalStiffness": 0.2, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"rootColor": [0.07, 0.009, 0.003], "tipColor": [0.34, 0.05, 0.008],
               "colorVariation": 0.25, "fiberRadius": 115e-6, "tipRadiusRatio": 0.15},
  "follow": {"countPerGuide": 10, "maxRadius": 0.003, "flyaways": 0.03}
})"},
    {"afro", "Tight dark curls that keep their volume and move as one.", R"({
  "simulation": {"damping": 0.12, "bendLength": 0.06, "globalStiffness": 0.25, "globalRange": 1,
                 "vspCoefficient": 0.4, "contact": {"stiffness": 0.2, "friction": 0.3}},
  "material": {"rootColor": [0.012, 0.008, 0.006], "tipColor": [0.03, 0.018, 0.012],
               "colorVariation": 0.25, "fiberRadius": 90e-6, "longitudinalRoughness": 0.4, "azimuthalRoughness": 0.5},
  "follow": {"countPerGuide": 16, "maxRadius": 0.004, "flyaways": 0.05}
})"},
    {"beard", "Short coarse hair that hardly moves.", R"({
  "simulation": {"damping": 0.15, "bendLength": 0.15, "globalStiffness": 0.35, "globalRange": 1,
                 "vspCoefficient": 0.5},
  "material": {"rootColor": [0.045, 0.022, 0.012], "tipColor": [0.16, 0.075, 0.035],
               "colorVariation": 0.3, "fiberRadius": 130e-6, "tipRadiusRatio": 0.5,
               "longitudinalRoughness": 0.35},
  "follow": {"countPerGuide": 6, "maxRadius": 0.003}
})"},
};

}  // namespace

std::span<const SettingsPreset> settingsPresets() { return kPresets; }

Result<SceneSettings> presetSettings(std::string_view name) {
  std::string names;
  for (const SettingsPreset& preset : kPresets) {
    if (preset.name == name)
      return parseSettings(preset.text, fmt::format("preset {}", preset.name));
    names += fmt::format("{}{}", names.empty() ? "" : ", ", preset.name);
  }
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("there is no preset '{}'; there are: {}", name, names)};
}

}  // namespace pelage
