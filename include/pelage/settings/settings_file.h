// Settings as JSON files, and as C++; kinds of hair to begin with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "pelage/settings/parameter.h"
#include "pelage/settings/scene_settings.h"
#include "pelage/simulation_settings.h"

namespace pelage {

/// The values that a file of settings sets. It is a JSON object with the members of SceneSettings,
/// and in these the names of docs/settings.md, all optional:
///
///     {"simulation": {"bendLength": 0.08, "wind": {"velocity": [2, 0, 0]}},
///      "material": {"model": "fiber"}, "lights": [{"shadow": "deep"}]}
///
/// Names of SimulationSettings may also be on the top level. Vectors and colors are arrays of three
/// numbers, curves of eight; choices are strings.
class SettingsFile {
 public:
  /// Loads and checks a file. Errors name the file and the setting, and say what it must be: no
  /// JSON, a name that is no setting or is there twice, a value of another type or out of range.
  static Result<SettingsFile> load(const std::filesystem::path& path);
  /// The same from text. \param name of the file, for errors.
  static Result<SettingsFile> parse(std::string_view text, std::string_view name);

  /// Sets what the file has, and nothing else. With "lights", there are afterwards as many lights
  /// as the file has; each begins with the light that was at its index, or with Light{}.
  void apply(SceneSettings& settings) const;
  /// The same of the simulation alone.
  void apply(SimulationSettings& settings) const;

  /// Whether it sets this: "simulation.bendLength", or a whole section: "lights".
  bool sets(std::string_view name) const;
  /// Names of the values that it sets, in the order of the table: "simulation.wind.velocity",
  /// "lights[0].color". Names of the simulation on the top level have no "simulation." in front.
  const std::vector<std::string>& names() const { return names_; }

 private:
  friend class SettingsReader;
  struct Value {
    size_t section = 0;  ///< index in settingsSections()
    size_t index = 0;    ///< of a list
    const Parameter* parameter = nullptr;
    ParameterValue value;
  };
  std::vector<Value> values_;
  std::vector<std::string> names_;
  bool hasLights_ = false;
  size_t lightCount_ = 0;
};

/// The settings of a file; those that it does not have are the defaults. Errors: SettingsFile's.
Result<SceneSettings> loadSettings(const std::filesystem::path& path);
/// The same from text. \param name of the file, for errors.
Result<SceneSettings> parseSettings(std::string_view text, std::string_view name);

/// The settings that are written.
enum class SettingsExtent : uint8_t {
  kChanges,  ///< what differs from the default
  kAll,
};

/// Settings as the JSON of SettingsFile: reading it gives the same bits. Where the lights differ
/// from those of SceneSettings{}, all of them are in it. Asserts that the settings are in range.
std::string settingsText(const SceneSettings& settings,
                         SettingsExtent extent = SettingsExtent::kChanges);
/// Writes settingsText() into a file. Errors: settings that are out of range; a file that cannot be
/// written, whose old contents then stay.
Result<void> saveSettings(const std::filesystem::path& path, const SceneSettings& settings,
                          SettingsExtent extent = SettingsExtent::kChanges);

/// C++ statements that set what differs from the defaults. Those of the simulation, the material,
/// the follow hairs, the lights, the transparency and the looks declare a variable; the others set
/// members of a HairObject `hair`, a HairDef `def`, an SdfCollider `collider` and a View `view`,
/// which must be there.
std::string settingsSnippet(const SceneSettings& settings);

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
