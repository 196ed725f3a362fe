// The panel at the left: what is shown, how it plays, what it costs.
#pragma once

#include <optional>

#include "canvas/canvas.h"
#include "interface/pass_history.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// What a user asks for that is not a plain value of the stage.
struct PanelWishes {
  std::optional<StageSource> source;
  bool framesAll = false, resets = false, takesScreenshot = false, losesDevice = false;
  bool togglesSettings = false, togglesStatistics = false, opensFiles = false;
  /// Side by side, or not any more.
  bool compares = false;
  std::optional<pelage::Solver> right;  ///< with `compares`
};

/// Builds the panel, which changes the stage. Call it between NewFrame() and Render() of ImGui.
PanelWishes buildStagePanel(Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size);

}  // namespace viewer
