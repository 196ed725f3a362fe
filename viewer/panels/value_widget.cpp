#include "value_widget.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "pelage/settings/scene_settings.h"

namespace viewer {

namespace {

// Smallest value above 0 of a logarithmic slider from 0, as a share of its high end.
constexpr double kSmallestShare = 1e-4;

double logLow(const pelage::Parameter& parameter) {
  if (parameter.sliderLow > 0) return parameter.sliderLow;
  const double low = kSmallestShare * parameter.sliderHigh;
  return parameter.type == pelage::ParameterType::kCount ? std::max(low, 1.0) : low;
}

double rounded(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
  return unit < 1 ? std::round(value / unit) / (1 / unit) : std::round(value / unit) * unit;
}

}  // namespace

double shareOf(const pelage::Parameter& parameter, double value) {
  const double low = parameter.sliderLow, high = parameter.sliderHigh;
  if (!(value > low)) return 0;
  if (!(value < high)) return 1;
  if (parameter.scale == pelage::ParameterScale::kLinear) return (value - low) / (high - low);
  const double least = logLow(parameter);
  return std::clamp(std::log(value / least) / std::log(high / least), 0.0, 1.0);
}

double valueAtShare(const pelage::Parameter& parameter, double share) {
  const double low = parameter.sliderLow, high = parameter.sliderHigh;
  if (!(share > 0)) return low;
  if (!(share < 1)) return high;
  double value = low + (high - low) * share;
  if (parameter.scale == pelage::ParameterScale::kLog) {
    const double least = logLow(parameter);
    value = least * std::pow(high / least, share);
  }
  value = parameter.type == pelage::ParameterType::kCount ? std::round(value) : rounded(value);
  return std::clamp(value, low, high);
}

namespace {

constexpr float kLastPoint = std::tuple_size_v<pelage::ParameterCurve> - 1;

struct Field {
  ImVec2 min, size;
  float low, high;

  ImVec2 at(size_t point, float value) const {
    const float share = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
    return {min.x + size.x * static_cast<float>(point) / kLastPoint, min.y + size.y * (1 - share)};
  }
  // Position of the mouse along the curve, in points from 0.
  float pointAt(const ImVec2& mouse) const {
    return std::clamp((mouse.x - min.x) / size.x, 0.0f, 1.0f) * kLastPoint;
  }
  float valueAt(const ImVec2& mouse) const {
    return low + (high - low) * std::clamp(1 - (mouse.y - min.y) / size.y, 0.0f, 1.0f);
  }
};

// Sets the points between two positions of the mouse to the line between them, and the point
// nearest to the second position.
void drawStroke(const Field& field, const ImVec2& from, const ImVec2& to,
                pelage::ParameterCurve& curve) {
  const float begin = field.pointAt(from), end = field.pointAt(to);
  for (size_t i = 0; i < curve.size(); ++i) {
    const auto point = static_cast<float>(i);
    if (point < std::min(begin, end) || point > std::max(begin, end)) continue;
    const float share = end == begin ? 1 : (point - begin) / (end - begin);
    curve[i] = std::lerp(field.valueAt(from), field.valueAt(to), share);
  }
  curve[static_cast<size_t>(std::lround(end))] = field.valueAt(to);
}

}  // namespace

bool editCurve(const char* id, pelage::ParameterCurve& curve, float low, float high, float width,
               float height) {
  const Field field = {ImGui::GetCursorScreenPos(), {width, height}, low, high};
  ImGui::InvisibleButton(id, field.size);
  const pelage::ParameterCurve before = curve;
  if (ImGui::IsItemActive()) {
    const ImGuiIO& io = ImGui::GetIO();
    const ImVec2 last = {io.MousePos.x - io.MouseDelta.x, io.MousePos.y - io.MouseDelta.y};
    drawStroke(field, ImGui::IsItemActivated() ? io.MousePos : last, io.MousePos, curve);
  }
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 max = {field.min.x + width, field.min.y + height};
  list.AddRectFilled(field.min, max, ImGui::GetColorU32(ImGuiCol_FrameBg));
  const ImVec2 one = field.at(0, 1);
  list.AddLine(one, {max.x, one.y}, ImGui::GetColorU32(ImGuiCol_Border));
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_PlotLines);
  for (size_t i = 0; i < curve.size(); ++i) {
    if (i > 0) list.AddLine(field.at(i - 1, curve[i - 1]), field.at(i, curve[i]), color, 2);
    list.AddCircleFilled(field.at(i, curve[i]), 3, color);
  }
  return curve != before;
}

namespace {

using pelage::choiceName;
using pelage::Float3;
using pelage::Parameter;
using pelage::ParameterCurve;
using pelage::ParameterScale;
using pelage::ParameterType;
using pelage::ParameterValue;

constexpr float kCurveLines = 3;       // height of a curve in lines of text
constexpr float kSliderShare = 0.36f;  // of the width, beside the number
constexpr float kDragSteps = 200;      // pixels from one end of a range to the other

// Draws a slider of shares, so that each scale has all digits.
bool slide(const Parameter& parameter, double& value) {
  auto share = static_cast<float>(shareOf(parameter, value));
  if (!ImGui::SliderFloat("##slider", &share, 0, 1, "", ImGuiSliderFlags_NoInput)) return false;
  value = valueAtShare(parameter, share);
  return true;
}

void textBeside(const std::string& text) {
  ImGui::SameLine();
  ImGui::TextUnformatted(text.c_str());
}

bool edit(const Parameter&, bool& value) { return ImGui::Checkbox("##box", &value); }

bool edit(const Parameter& parameter, float& value) {
  ImGui::SetNextItemWidth(kSliderShare * ImGui::CalcItemWidth());
  bool changed = false;
  if (parameter.scale == ParameterScale::kLog) {
    auto number = static_cast<double>(value);
    changed = slide(parameter, number);
    if (changed) value = static_cast<float>(number);
  } else {
    changed = ImGui::SliderFloat("##slider", &value, static_cast<float>(parameter.sliderLow),
                                 static_cast<float>(parameter.sliderHigh), "");
    // Typed numbers keep all their digits.
    if (changed && ImGui::IsMouseDown(ImGuiMouseButton_Left))
      value = static_cast<float>(rounded(static_cast<double>(value)));
  }
  textBeside(valueText(parameter, value));
  return changed;
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
  ImGui::SetNextItemWidth(kSliderShare * ImGui::CalcItemWidth());
  auto number = static_cast<double>(value);
  const bool changed = slide(parameter, number);
  if (changed) value = static_cast<uint64_t>(number);
  if (changed && parameter.isPowerOfTwo) value = std::bit_floor(value);
  textBeside(valueText(parameter, value));
  return changed;
}

bool editVector(const Parameter& parameter, float* xyz) {
  const std::string unit(parameter.unit);
  const float unitWidth =
      unit.empty() ? 0 : ImGui::CalcTextSize(unit.c_str()).x + ImGui::GetStyle().ItemSpacing.x;
  ImGui::SetNextItemWidth(std::max(ImGui::CalcItemWidth() - unitWidth, 1.0f));
  const auto low = static_cast<float>(parameter.sliderLow);
  const auto high = static_cast<float>(parameter.sliderHigh);
  const bool changed =
      ImGui::DragFloat3("##vector", xyz, (high - low) / kDragSteps, low, high, "%.3g");
  if (!unit.empty()) textBeside(unit);
  return changed;
}

bool edit(const Parameter& parameter, Float3& value) {
  float xyz[3] = {value.x, value.y, value.z};
  constexpr ImGuiColorEditFlags kFlags = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR;
  const bool changed = parameter.type == ParameterType::kColor
                           ? ImGui::ColorEdit3("##color", xyz, kFlags)
                           : editVector(parameter, xyz);
  value = {xyz[0], xyz[1], xyz[2]};
  return changed;
}

bool edit(const Parameter& parameter, ParameterCurve& value) {
  return editCurve("##curve", value, static_cast<float>(parameter.sliderLow),
                   static_cast<float>(parameter.sliderHigh), ImGui::CalcItemWidth(),
                   kCurveLines * ImGui::GetFrameHeight());
}

// Clamps a number that a user typed to the range.
float inRange(const Parameter& parameter, float value) {
  if (!std::isfinite(value)) return value;
  return std::clamp(value, std::isfinite(parameter.low) ? static_cast<float>(parameter.low) : value,
                    std::isfinite(parameter.high) ? static_cast<float>(parameter.high) : value);
}

}  // namespace

bool editValue(const Parameter& parameter, ParameterValue& value) {
  const ParameterValue before = value;
  ImGui::BeginGroup();
  std::visit([&](auto& of) { return edit(parameter, of); }, value);
  ImGui::EndGroup();
  if (auto* number = std::get_if<float>(&value); number != nullptr)
    *number = inRange(parameter, *number);
  if (auto* xyz = std::get_if<Float3>(&value); xyz != nullptr)
    *xyz = {inRange(parameter, xyz->x), inRange(parameter, xyz->y), inRange(parameter, xyz->z)};
  if (!check(parameter, value)) value = before;
  return !haveSameBits(value, before);
}

std::string wordsOf(std::string_view name) {
  std::string words;
  for (const char c : name) {
    const bool isUpper = c >= 'A' && c <= 'Z';
    if (isUpper) words += ' ';
    words += isUpper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return words;
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
