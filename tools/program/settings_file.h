// Simulation settings as a JSON file.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "pelage/simulation_settings.h"

namespace pelage::program {

/// What a file of settings sets: an object with the names of SimulationSettings, all optional.
/// Vectors are arrays of three numbers, curves of eight; the solver is "exact" or "classic".
///
///     {"bendLength": 0.08, "gravity": [0, -9.81, 0], "wind": {"velocity": [2, 0, 0]}}
class SettingsFile {
 public:
  /// Loads and checks a file. Errors name the file and the setting: no JSON, a name that is no
  /// setting or is there twice, a value of another type, one that validate() refuses.
  static Result<SettingsFile> load(const std::filesystem::path& path);
  /// The same from text; `name` names it in errors.
  static Result<SettingsFile> parse(std::string_view text, std::string_view name);

  /// Sets what the file has, and nothing else.
  void apply(SimulationSettings& settings) const;
  /// Names of what it sets, in order: "bendLength", "wind.velocity".
  const std::vector<std::string>& names() const { return names_; }

 private:
  struct Values;
  std::shared_ptr<const Values> values_;
  std::vector<std::string> names_;
};

}  // namespace pelage::program
