// Areas of the windows right of the panel: none covers another.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"
#include "window/window.h"

namespace viewer {

inline constexpr float kPanelWidth = 270;  ///< of the panel at the left, at scale 1

/// In window coordinates.
struct WindowArea {
  pelage::Float2 corner, size;
};

/// Returns an area for each window: in columns from the right, above the arrow of the wind. Windows
/// of one column share its height. \param heights wanted [at scale 1].
std::vector<WindowArea> windowAreas(const WindowSize& size, std::span<const float> heights);

/// Windows that open beside the panel, in the order of their areas.
enum class SideWindow : uint8_t { kSettings, kStatistics, kHelp, kFiles };

/// Places windows when one opens or closes, or when the viewer's window has another size. In
/// between a user may move them.
class WindowLayout {
 public:
  /// Begins a frame. \param open [SideWindow]
  void begin(const WindowSize& size, const std::array<bool, 4>& open);
  /// Places the next window of ImGui.
  void place(SideWindow window) const;

 private:
  std::array<bool, 4> open_ = {};
  uint32_t width_ = 0, height_ = 0;
  bool isNew_ = false;
  std::array<WindowArea, 4> areas_ = {};
};

}  // namespace viewer
