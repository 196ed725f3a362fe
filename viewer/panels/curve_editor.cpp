#include "curve_editor.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

constexpr float kLastPoint = std::tuple_size_v<pelage::ParameterCurve> - 1;

struct Field {
  ImVec2 min, size;
  float low, high;

  ImVec2 at(size_t point, float value) const {
    const float share = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
    return {min.x + size.x * static_cast<float>(point) / kLastPoint, min.y + size.y * (1 - share)};
  }
  // Of a position of the mouse: the points counted from 0, and the value.
  float pointAt(const ImVec2& mouse) const {
    return std::clamp((mouse.x - min.x) / size.x, 0.0f, 1.0f) * kLastPoint;
  }
  float valueAt(const ImVec2& mouse) const {
    return low + (high - low) * std::clamp(1 - (mouse.y - min.y) / size.y, 0.0f, 1.0f);
  }
};

// Sets the points between where the mouse was and where it is to the line that it drew, and the
// one that it is nearest to.
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

}  // namespace viewer
