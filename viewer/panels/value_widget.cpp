#include "value_widget.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "curve_editor.h"
#include "pelage/settings/scene_settings.h"
#include "value_scale.h"

namespace viewer {
namespace {

using pelage::choiceName;
using pelage::Float3;
using pelage::Parameter;
using pelage::ParameterCurve;
using pelage::ParameterScale;
using pelage::ParameterType;
using pelage::ParameterValue;

constexpr float kCurveLines = 3;  // height of a curve in lines of text

std::string escaped(const std::string& text) {
  std::string format;
  for (const char c : text) format += c == '%' ? "%%" : std::string(1, c);
  return format;
}

// A slider over shares, so that every scale has every digit. Its text is the value.
bool slide(const Parameter& parameter, double& value, const ParameterValue& shown) {
  auto share = static_cast<float>(shareOf(parameter, value));
  const std::string format = escaped(valueText(parameter, shown));
  if (!ImGui::SliderFloat("##slider", &share, 0, 1, format.c_str(), ImGuiSliderFlags_NoInput))
    return false;
  value = valueAtShare(parameter, share);
  return true;
}

bool edit(const Parameter&, bool& value) { return ImGui::Checkbox("##box", &value); }

bool edit(const Parameter& parameter, float& value) {
  if (parameter.scale == ParameterScale::kLog) {
    auto number = static_cast<double>(value);
    if (!slide(parameter, number, value)) return false;
    value = static_cast<float>(number);
    return true;
  }
  const std::string format =
      "%.4g" + escaped(parameter.unit.empty() ? "" : " ") + escaped(std::string(parameter.unit));
  return ImGui::SliderFloat("##slider", &value, static_cast<float>(parameter.sliderLow),
                            static_cast<float>(parameter.sliderHigh), format.c_str());
}

bool editChoice(const Parameter& parameter, uint64_t& value) {
  bool changed = false;
  if (!ImGui::BeginCombo("##choice", choiceName(parameter.choices[value]).c_str())) return false;
  for (size_t i = 0; i < parameter.choices.size(); ++i)
    if (ImGui::Selectable(choiceName(parameter.choices[i]).c_str(), i == value)) {
      value = i;
      changed = true;
    }
  ImGui::EndCombo();
  return changed;
}

bool edit(const Parameter& parameter, uint64_t& value) {
  if (parameter.type == ParameterType::kChoice) return editChoice(parameter, value);
  auto number = static_cast<double>(value);
  if (!slide(parameter, number, value)) return false;
  value = static_cast<uint64_t>(number);
  if (parameter.isPowerOfTwo) value = std::bit_floor(value);
  return true;
}

bool edit(const Parameter& parameter, Float3& value) {
  float xyz[3] = {value.x, value.y, value.z};
  constexpr ImGuiColorEditFlags kFlags = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR;
  const bool changed =
      parameter.type == ParameterType::kColor
          ? ImGui::ColorEdit3("##color", xyz, kFlags)
          : ImGui::SliderFloat3("##vector", xyz, static_cast<float>(parameter.sliderLow),
                                static_cast<float>(parameter.sliderHigh), "%.3g");
  value = {xyz[0], xyz[1], xyz[2]};
  return changed;
}

bool edit(const Parameter& parameter, ParameterCurve& value) {
  return editCurve("##curve", value, static_cast<float>(parameter.sliderLow),
                   static_cast<float>(parameter.sliderHigh), ImGui::CalcItemWidth(),
                   kCurveLines * ImGui::GetFrameHeight());
}

// The nearest value in range of numbers that a user typed.
float inRange(const Parameter& parameter, float value) {
  if (!std::isfinite(value)) return value;
  return std::clamp(value, std::isfinite(parameter.low) ? static_cast<float>(parameter.low) : value,
                    std::isfinite(parameter.high) ? static_cast<float>(parameter.high) : value);
}

}  // namespace

bool editValue(const Parameter& parameter, ParameterValue& value) {
  const ParameterValue before = value;
  std::visit([&](auto& of) { return edit(parameter, of); }, value);
  if (auto* number = std::get_if<float>(&value); number != nullptr)
    *number = inRange(parameter, *number);
  if (auto* xyz = std::get_if<Float3>(&value); xyz != nullptr)
    *xyz = {inRange(parameter, xyz->x), inRange(parameter, xyz->y), inRange(parameter, xyz->z)};
  if (!check(parameter, value)) value = before;
  return !haveSameBits(value, before);
}

std::string valueText(const Parameter& parameter, const ParameterValue& value) {
  const std::string unit = parameter.unit.empty() ? "" : fmt::format(" {}", parameter.unit);
  if (const auto* number = std::get_if<float>(&value))
    return fmt::format("{:.4g}{}", *number, unit);
  if (const auto* count = std::get_if<uint64_t>(&value)) {
    if (parameter.type == ParameterType::kChoice) return choiceName(parameter.choices[*count]);
    constexpr uint64_t kMebibyte = 1 << 20;
    if (parameter.field == "drawnStrands" && *count == pelage::kAllStrands) return "all";
    if (parameter.unit == "bytes") return fmt::format("{} MiB", *count / kMebibyte);
    return fmt::format("{}{}", *count, unit);
  }
  return "";
}

std::string tooltipText(const Parameter& parameter) {
  std::string text = fmt::format("{}::{}\n{}", parameter.owner, parameter.field,
                                 pelage::plainText(parameter.meaning));
  if (!parameter.unit.empty()) text += fmt::format("\nUnit: {}", parameter.unit);
  if (!parameter.range.empty()) text += fmt::format("\nRange: {}", parameter.range);
  if (!parameter.solver.empty())
    text += fmt::format("\nOnly the {} solver uses it.", parameter.solver);
  return text;
}

}  // namespace viewer
