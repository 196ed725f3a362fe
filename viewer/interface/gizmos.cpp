#include "interface/gizmos.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <string>

#include "stage/projection.h"
#include "stage/wind_arrow.h"

namespace viewer {

namespace {

constexpr ImU32 kColor = IM_COL32(255, 205, 90, 230);
constexpr ImU32 kFaint = IM_COL32(255, 205, 90, 90);

void drawWind(const Stage& stage, const WindowSize& size, ImDrawList& list) {
  const pelage::Float3& wind = stage.look.wind;
  const WindArrow arrow = windArrowOf(stage.camera, wind, size);
  const ImVec2 base = {arrow.base.x, arrow.base.y}, tip = {arrow.tip.x, arrow.tip.y};
  const float scale = size.interfaceScale;
  list.AddCircleFilled(base, 3 * scale, kColor);
  list.AddLine(base, tip, kColor, 2.5f * scale);
  const float x = tip.x - base.x, y = tip.y - base.y, length = std::hypot(x, y);
  if (length > 1) {
    const float ux = x / length * 9 * scale, uy = y / length * 9 * scale;
    list.AddTriangleFilled({tip.x + ux, tip.y + uy}, {tip.x - uy * 0.6f, tip.y + ux * 0.6f},
                           {tip.x + uy * 0.6f, tip.y - ux * 0.6f}, kColor);
  }
  list.AddCircle(tip, arrow.tipRadius, kFaint);
  const std::string text = fmt::format(
      "wind {:.1f} m/s", std::sqrt(wind.x * wind.x + wind.y * wind.y + wind.z * wind.z));
  list.AddText({base.x - 40 * scale, static_cast<float>(size.height) - 18 * scale}, kColor,
               text.c_str());
}

void drawPull(const Stage& stage, const WindowSize& size, ImDrawList& list) {
  if (!stage.pull.holds()) return;
  const pelage::View view = stage.camera.view(size.width, size.height);
  const auto from = project(view, stage.pull.point()), to = project(view, stage.pull.target());
  if (!from || !to) return;
  list.AddLine({from->x, from->y}, {to->x, to->y}, kFaint, 1.5f * size.interfaceScale);
  list.AddCircle({to->x, to->y}, 6 * size.interfaceScale, kColor);
}

}  // namespace

void drawGizmos(const Stage& stage, const WindowSize& size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  drawWind(stage, size, list);
  drawPull(stage, size, list);
}

}  // namespace viewer
