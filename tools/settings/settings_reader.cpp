// Reads JSON by the table of parameters.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "pelage/settings/settings_file.h"
#include "settings_names.h"

namespace pelage {
namespace {

using nlohmann::json;

// The nearest float; infinite beyond the largest.
float toFloat(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  constexpr double kRoundsToInfinity = kLargest * (1 + 0x1p-25);
  if (std::abs(value) >= kRoundsToInfinity)
    return std::copysign(std::numeric_limits<float>::infinity(), value > 0 ? 1.0f : -1.0f);
  return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}

template <size_t kCount>
std::optional<std::array<float, kCount>> numbers(const json& from) {
  if (!from.is_array() || from.size() != kCount) return std::nullopt;
  std::array<float, kCount> values{};
  for (size_t i = 0; i < kCount; ++i) {
    if (!from[i].is_number()) return std::nullopt;
    values[i] = toFloat(from[i].get<double>());
  }
  return values;
}

std::optional<ParameterValue> choice(const Parameter& parameter, const json& from) {
  if (!from.is_string()) return std::nullopt;
  for (size_t i = 0; i < parameter.choices.size(); ++i)
    if (choiceName(parameter.choices[i]) == from.get_ref<const std::string&>()) return uint64_t{i};
  return std::nullopt;
}

std::optional<ParameterValue> valueOf(const Parameter& parameter, const json& from) {
  switch (parameter.type) {
    case ParameterType::kBool:
      if (from.is_boolean()) return from.get<bool>();
      break;
    case ParameterType::kCount:
      if (from.is_number_unsigned()) return from.get<uint64_t>();
      break;
    case ParameterType::kFloat:
      if (parameter.takesInfinity && from == "infinity")
        return std::numeric_limits<float>::infinity();
      if (from.is_number()) return toFloat(from.get<double>());
      break;
    case ParameterType::kVector:
    case ParameterType::kColor:
      if (const auto xyz = numbers<3>(from)) return Float3{(*xyz)[0], (*xyz)[1], (*xyz)[2]};
      break;
    case ParameterType::kCurve:
      if (const auto curve = numbers<std::tuple_size_v<ParameterCurve>>(from)) return *curve;
      break;
    case ParameterType::kChoice:
      return choice(parameter, from);
  }
  return std::nullopt;
}

// Names the type that a value should have had.
std::string wanted(const Parameter& parameter) {
  switch (parameter.type) {
    case ParameterType::kBool:
      return "true or false";
    case ParameterType::kCount:
      return "a whole number of at least 0";
    case ParameterType::kFloat:
      return parameter.takesInfinity ? "a number, or \"infinity\"" : "a number";
    case ParameterType::kVector:
    case ParameterType::kColor:
      return "an array of 3 numbers";
    case ParameterType::kCurve:
      return "an array of 8 numbers";
    case ParameterType::kChoice:
      break;
  }
  std::string names;
  for (size_t i = 0; i < parameter.choices.size(); ++i) {
    const char* before = i == 0 ? "" : i + 1 < parameter.choices.size() ? ", " : " or ";
    names += fmt::format("{}\"{}\"", before, choiceName(parameter.choices[i]));
  }
  return names;
}

std::string listed(const std::set<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

// The JSON, with an error for a name that is in one object twice.
Result<json> parseJson(std::string_view text, std::string_view name) {
  std::vector<std::set<std::string>> open;
  std::string twice;
  const auto note = [&](int, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start) open.emplace_back();
    if (event == json::parse_event_t::object_end) open.pop_back();
    if (event == json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second)
      twice = value.get<std::string>();
    return true;
  };
  const auto fail = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, what)};
  };
  try {
    json parsed = json::parse(text, note);
    if (!twice.empty()) return fail(fmt::format("'{}' is there twice", twice));
    if (!parsed.is_object()) return fail("it must be a JSON object: { ... }");
    return parsed;
  } catch (const json::parse_error& error) {
    return fail(fmt::format("byte {}: the JSON is damaged here, or is none", error.byte));
  } catch (const json::exception& error) {
    return fail(error.what());
  }
}

}  // namespace

/// Takes the values of a JSON object in the order of the table. The first error stays.
class SettingsReader {
 public:
  explicit SettingsReader(SettingsFile& file) : file_(file) {}

  std::optional<std::string> read(const json& top) {
    checkTop(top);
    const std::span<const SettingsSection> sections = settingsSections();
    for (size_t s = 0; s < sections.size(); ++s) {
      // Settings of the simulation may be on the top level.
      if (s == 0) takeSection(0, 0, top, "");
      const auto found = top.find(std::string(sections[s].key));
      if (found == top.end()) continue;
      if (sections[s].isList)
        readList(s, *found);
      else
        readObject(s, 0, *found, std::string(sections[s].key));
    }
    return error_;
  }

 private:
  void fail(std::string what) {
    if (!error_) error_ = std::move(what);
  }

  // Refuses names on the top level that are neither a section nor of the simulation.
  void checkTop(const json& top) {
    std::set<std::string> keys;
    for (const SettingsSection& section : settingsSections()) keys.insert(std::string(section.key));
    for (const auto& [name, value] : top.items())
      if (!keys.contains(name)) checkName(0, name, value, "", "", keys);
  }

  // Refuses names of an object that no parameter has. `inside` is its path in the section: "wind.".
  void checkNames(size_t section, const json& object, const std::string& inside,
                  const std::string& prefix) {
    for (const auto& [name, value] : object.items())
      checkName(section, name, value, inside, prefix, {});
  }

  void checkName(size_t section, const std::string& name, const json& value,
                 const std::string& inside, const std::string& prefix,
                 const std::set<std::string>& others) {
    const std::string path = inside + name;
    const bool pointed = name.find('.') != std::string::npos;
    std::set<std::string> known = others;
    for (const Parameter& parameter : settingsSections()[section].parameters) {
      if (parameter.path == path && !pointed) return;
      if (parameter.path.starts_with(path + '.') && !pointed) {
        if (value.is_object()) return checkNames(section, value, path + '.', prefix);
        return fail(fmt::format("'{}{}' must be an object", prefix, path));
      }
      if (!parameter.path.starts_with(inside)) continue;
      const std::string_view rest = parameter.path.substr(inside.size());
      known.insert(std::string(rest.substr(0, rest.find('.'))));
    }
    fail(fmt::format("'{}{}' is no setting; there are: {}", prefix, path, listed(known)));
  }

  void readObject(size_t section, size_t index, const json& object, const std::string& name) {
    if (!object.is_object()) return fail(fmt::format("'{}' must be an object", name));
    checkNames(section, object, "", name + '.');
    takeSection(section, index, object, name + '.');
  }

  void readList(size_t section, const json& list) {
    const std::string key(settingsSections()[section].key);
    if (!list.is_array() || list.size() > kMaxLights)
      return fail(fmt::format("'{}' must be an array of at most {} objects", key, kMaxLights));
    file_.hasLights_ = true;
    file_.lightCount_ = list.size();
    file_.names_.push_back(key);
    for (size_t i = 0; i < list.size(); ++i)
      readObject(section, i, list[i], fmt::format("{}[{}]", key, i));
  }

  // The values of all parameters that are there.
  void takeSection(size_t section, size_t index, const json& object, const std::string& prefix) {
    for (const Parameter& parameter : settingsSections()[section].parameters) {
      const json* found = &object;
      std::string_view rest = parameter.path;
      while (found != nullptr && !rest.empty()) {
        const size_t point = std::min(rest.find('.'), rest.size());
        const auto member = found->find(std::string(rest.substr(0, point)));
        found = member == found->end() ? nullptr : &*member;
        rest.remove_prefix(std::min(point + 1, rest.size()));
        if (found != nullptr && !rest.empty() && !found->is_object()) found = nullptr;
      }
      if (found != nullptr) take(section, index, parameter, *found, prefix);
      if (error_) return;
    }
  }

  void take(size_t section, size_t index, const Parameter& parameter, const json& from,
            const std::string& prefix) {
    const std::string name = prefix + std::string(parameter.path);
    const std::optional<ParameterValue> value = valueOf(parameter, from);
    if (!value) return fail(fmt::format("'{}' must be {}", name, wanted(parameter)));
    if (Result<void> checked = check(parameter, *value, name); !checked)
      return fail(checked.error().message);
    for (const SettingsFile::Value& other : file_.values_)
      if (other.section == section && other.index == index && other.parameter == &parameter)
        return fail(fmt::format("'{}' is there twice: on the top level, too", name));
    file_.values_.push_back({section, index, &parameter, *value});
    file_.names_.push_back(name);
  }

  SettingsFile& file_;
  std::optional<std::string> error_;
};

Result<SettingsFile> SettingsFile::load(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf()))
    return Error{ErrorCode::kFileNotFound, path.string() + ": no such file, or nothing in it"};
  return parse(text.str(), path.string());
}

Result<SettingsFile> SettingsFile::parse(std::string_view text, std::string_view name) {
  const auto object = parseJson(text, name);
  if (!object) return object.error();
  SettingsFile file;
  SettingsReader reader(file);
  if (const auto wrong = reader.read(*object))
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, *wrong)};
  SceneSettings settings;
  file.apply(settings);
  if (auto valid = validate(settings); !valid)
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, valid.error().message)};
  return file;
}

void SettingsFile::apply(SceneSettings& settings) const {
  if (hasLights_) settings.lights.resize(lightCount_);
  for (const Value& value : values_)
    settingsSections()[value.section].set(settings, *value.parameter, value.value, value.index);
}

void SettingsFile::apply(SimulationSettings& settings) const {
  for (const Value& value : values_)
    if (value.section == 0) value.parameter->set(&settings, value.value);
}

bool SettingsFile::sets(std::string_view name) const {
  if (name == "lights" && hasLights_) return true;
  for (const Value& value : values_) {
    const SettingsSection& section = settingsSections()[value.section];
    if (section.key == name ||
        settings::nameOf(section, value.index, value.parameter->path) == name)
      return true;
  }
  return false;
}

Result<SceneSettings> loadSettings(const std::filesystem::path& path) {
  const auto file = SettingsFile::load(path);
  if (!file) return file.error();
  SceneSettings settings;
  file->apply(settings);
  return settings;
}

Result<SceneSettings> parseSettings(std::string_view text, std::string_view name) {
  const auto file = SettingsFile::parse(text, name);
  if (!file) return file.error();
  SceneSettings settings;
  file->apply(settings);
  return settings;
}

}  // namespace pelage
