// Writes JSON by the table of parameters.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include "pelage/assert.h"
#include "pelage/settings/settings_file.h"

namespace pelage {
namespace {

// The shortest number that a reader of doubles makes the same float of. JSON has a -0.0, but -0 is
// the whole number 0 to many.
std::string text(float value) {
  if (std::isinf(value)) return "\"infinity\"";
  if (value == 0) return std::signbit(value) ? "-0.0" : "0";
  std::string digits = fmt::format("{}", value);
  double read = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), read);
  if (static_cast<float>(read) != value) digits = fmt::format("{}", static_cast<double>(value));
  return digits;
}

std::string text(const Parameter& parameter, const ParameterValue& value) {
  switch (parameter.type) {
    case ParameterType::kBool:
      return std::get<bool>(value) ? "true" : "false";
    case ParameterType::kCount:
      return fmt::format("{}", std::get<uint64_t>(value));
    case ParameterType::kFloat:
      return text(std::get<float>(value));
    case ParameterType::kVector:
    case ParameterType::kColor: {
      const auto& xyz = std::get<Float3>(value);
      return fmt::format("[{}, {}, {}]", text(xyz.x), text(xyz.y), text(xyz.z));
    }
    case ParameterType::kCurve: {
      std::string list;
      for (const float number : std::get<ParameterCurve>(value))
        list += (list.empty() ? "" : ", ") + text(number);
      return '[' + list + ']';
    }
    case ParameterType::kChoice:
      break;
  }
  return '"' + choiceName(parameter.choices[std::get<uint64_t>(value)]) + '"';
}

// A member of an object and its JSON.
using Member = std::pair<std::string, std::string>;

std::string indented(const std::string& lines) {
  std::string result;
  for (const char c : lines) result += c == '\n' ? "\n  " : std::string(1, c);
  return result;
}

// `brackets` around lines.
std::string block(const std::vector<std::string>& lines, std::string_view brackets) {
  if (lines.empty()) return std::string(brackets);
  std::string body;
  for (const std::string& line : lines) body += (body.empty() ? "\n  " : ",\n  ") + indented(line);
  return fmt::format("{}{}\n{}", brackets[0], body, brackets[1]);
}

std::string object(const std::vector<Member>& members) {
  std::vector<std::string> lines;
  for (size_t i = 0; i < members.size();) {
    const std::string& name = members[i].first;
    const size_t point = name.find('.');
    if (point == std::string::npos) {
      lines.push_back(fmt::format("\"{}\": {}", name, members[i++].second));
      continue;
    }
    // The members of an object inside are beside each other.
    const std::string prefix = name.substr(0, point + 1);
    std::vector<Member> inside;
    for (; i < members.size() && members[i].first.starts_with(prefix); ++i)
      inside.emplace_back(members[i].first.substr(prefix.size()), members[i].second);
    lines.push_back(fmt::format("\"{}\": {}", prefix.substr(0, point), object(inside)));
  }
  return block(lines, "{}");
}

std::vector<Member> members(const SettingsSection& section, const SceneSettings& settings,
                            size_t index, SettingsExtent extent) {
  std::vector<Member> result;
  for (const Parameter& parameter : section.parameters) {
    const ParameterValue value = section.get(settings, parameter, index);
    if (extent == SettingsExtent::kAll || !haveSameBits(value, parameter.defaultValue))
      result.emplace_back(parameter.path, text(parameter, value));
  }
  return result;
}

bool isDefault(const SettingsSection& section, const SceneSettings& settings) {
  static const SceneSettings untouched;
  if (section.count(settings) != section.count(untouched)) return false;
  for (size_t i = 0; i < section.count(settings); ++i)
    if (!members(section, settings, i, SettingsExtent::kChanges).empty()) return false;
  return true;
}

}  // namespace

std::string settingsText(const SceneSettings& settings, SettingsExtent extent) {
  PELAGE_ASSERT(static_cast<bool>(validate(settings)), "settings that are out of range");
  std::vector<std::string> lines;
  for (const SettingsSection& section : settingsSections()) {
    if (extent == SettingsExtent::kChanges && isDefault(section, settings)) continue;
    std::vector<std::string> objects;
    for (size_t i = 0; i < section.count(settings); ++i)
      objects.push_back(object(members(section, settings, i, extent)));
    lines.push_back(
        fmt::format("\"{}\": {}", section.key, section.isList ? block(objects, "[]") : objects[0]));
  }
  return block(lines, "{}") + '\n';
}

Result<void> saveSettings(const std::filesystem::path& path, const SceneSettings& settings,
                          SettingsExtent extent) {
  if (Result<void> valid = validate(settings); !valid)
    return Error{valid.error().code,
                 fmt::format("{}: not written: {}", path.string(), valid.error().message)};
  // Beside it first, so that a full disk leaves the old file.
  std::filesystem::path beside = path;
  beside += ".new";
  std::error_code failed;
  {
    std::ofstream file(beside, std::ios::binary);
    file << settingsText(settings, extent);
    if (!file.flush()) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) std::filesystem::rename(beside, path, failed);
  if (!failed) return {};
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  return Error{ErrorCode::kFileNotFound,
               path.string() + ": cannot be written; is there such a folder, and room?"};
}

}  // namespace pelage
