#include "interface/window_layout.h"

#include <imgui.h>

#include <algorithm>

#include "stage/controls.h"

namespace viewer {

namespace {

constexpr float kMargin = 8, kColumnWidth = 420;                 // at scale 1
constexpr std::array<float, 4> kHeights = {520, 460, 560, 360};  // [SideWindow], likewise
constexpr float kLeastSize = 32;                                 // of a window of ImGui

}  // namespace

std::vector<WindowArea> windowAreas(const WindowSize& size, std::span<const float> heights) {
  const float scale = size.interfaceScale, margin = kMargin * scale;
  const float right = static_cast<float>(size.width) - margin;
  const float bottom = static_cast<float>(size.height) - windArrowHeight(size);
  const float room = std::max(right - kPanelWidth * scale - 2 * margin, kLeastSize);
  const float width = std::min(kColumnWidth * scale, room);
  const auto columns = std::clamp<size_t>(static_cast<size_t>((room + margin) / (width + margin)),
                                          1, heights.size());
  std::vector<WindowArea> areas;
  for (size_t i = 0; i < heights.size(); ++i) {
    const size_t column = i % columns, row = i / columns;
    const auto rows = static_cast<float>((heights.size() - column + columns - 1) / columns);
    const float share = std::max((bottom - margin * rows) / rows, kLeastSize);
    areas.push_back({{right - width - static_cast<float>(column) * (width + margin),
                      margin + static_cast<float>(row) * (share + margin)},
                     {width, std::min(heights[i] * scale, share)}});
  }
  return areas;
}

void WindowLayout::begin(const WindowSize& size, const std::array<bool, 4>& open) {
  isNew_ = open != open_ || size.width != width_ || size.height != height_;
  open_ = open;
  width_ = size.width;
  height_ = size.height;
  if (!isNew_ || std::count(open.begin(), open.end(), true) == 0) return;
  std::vector<float> heights;
  for (size_t i = 0; i < open.size(); ++i)
    if (open[i]) heights.push_back(kHeights[i]);
  const std::vector<WindowArea> areas = windowAreas(size, heights);
  for (size_t i = 0, next = 0; i < open.size(); ++i)
    if (open[i]) areas_[i] = areas[next++];
}

void WindowLayout::place(SideWindow window) const {
  if (!isNew_) return;
  const WindowArea& area = areas_[static_cast<size_t>(window)];
  ImGui::SetNextWindowPos({area.corner.x, area.corner.y});
  ImGui::SetNextWindowSize({area.size.x, area.size.y});
}

}  // namespace viewer
