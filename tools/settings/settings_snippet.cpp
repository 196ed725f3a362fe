// Settings as C++.
#include <fmt/format.h>

#include <cmath>

#include "pelage/settings/settings_file.h"

namespace pelage {
namespace {

std::string literal(float value) {
  if (std::isinf(value)) return "std::numeric_limits<float>::infinity()";
  std::string digits = fmt::format("{}", value);
  if (digits.find_first_of(".e") == std::string::npos) digits += ".0";
  return digits + 'f';
}

// The type of a choice.
std::string_view enumOf(const Parameter& parameter) {
  if (parameter.field == "solver") return "Solver";
  if (parameter.field == "model") return "ShadingModel";
  if (parameter.field == "shadow") return "HairShadow";
  if (parameter.field == "method") return "Transparency";
  return parameter.field == "skinning" ? "SkinningMethod" : "CollidingHair";
}

std::string literal(const Parameter& parameter, const ParameterValue& value) {
  switch (parameter.type) {
    case ParameterType::kBool:
      return std::get<bool>(value) ? "true" : "false";
    case ParameterType::kCount: {
      const uint64_t count = std::get<uint64_t>(value);
      return fmt::format("{}{}", count, count > 0x7fffffffu ? "u" : "");
    }
    case ParameterType::kFloat:
      return literal(std::get<float>(value));
    case ParameterType::kVector:
    case ParameterType::kColor: {
      const auto& xyz = std::get<Float3>(value);
      return fmt::format("{{{}, {}, {}}}", literal(xyz.x), literal(xyz.y), literal(xyz.z));
    }
    case ParameterType::kCurve: {
      std::string list;
      for (const float number : std::get<ParameterCurve>(value))
        list += (list.empty() ? "" : ", ") + literal(number);
      return '{' + list + '}';
    }
    case ParameterType::kChoice:
      break;
  }
  return fmt::format("pelage::{}::{}", enumOf(parameter),
                     parameter.choices[std::get<uint64_t>(value)]);
}

// How statements name the struct of a section, and what declares it, if anything.
struct Variable {
  std::string name, declaration;
};

Variable variableOf(const SettingsSection& section, const SceneSettings& settings) {
  const std::string key(section.key);
  if (key == "simulation") return {key, "pelage::SimulationSettings simulation;\n"};
  if (key == "material") return {key, "pelage::StrandMaterial material;\n"};
  if (key == "follow") return {key, "pelage::FollowDef follow;\n"};
  if (key == "colliderLook") return {key, "pelage::ColliderLook colliderLook;\n"};
  if (key == "contactLook") return {key, "pelage::ContactLook contactLook;\n"};
  if (key == "transparency") return {key, "pelage::TransparencySettings transparency;\n"};
  if (section.isList)
    return {key, fmt::format("std::vector<pelage::Light> lights({});\n", settings.lights.size())};
  if (key == "object") return {"hair", ""};
  if (key == "creation") return {"def", ""};
  return {key, ""};
}

}  // namespace

std::string settingsSnippet(const SceneSettings& settings) {
  static const SceneSettings untouched;
  std::string code;
  for (const SettingsSection& section : settingsSections()) {
    const Variable variable = variableOf(section, settings);
    std::string statements;
    for (size_t i = 0; i < section.count(settings); ++i)
      for (const Parameter& parameter : section.parameters) {
        const ParameterValue value = section.get(settings, parameter, i);
        if (haveSameBits(value, parameter.defaultValue)) continue;
        statements += fmt::format("{}{}.{} = {};\n", variable.name,
                                  section.isList ? fmt::format("[{}]", i) : "", parameter.path,
                                  literal(parameter, value));
      }
    if (!statements.empty() || section.count(settings) != section.count(untouched))
      code += variable.declaration + statements;
  }
  return code;
}

}  // namespace pelage
