// The panel at the left, the key of a view of errors, and the gizmos that the mouse drags. Call
// these functions between NewFrame() and Render() of ImGui.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "canvas/canvas.h"
#include "capture/pass_times.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// Files that a user wants to see.
struct FileChoice {
  std::vector<std::filesystem::path> files;
  bool adds = false;  ///< beside the files that are shown, not in place of them
};

/// Wishes of a user that are not plain values of the stage.
struct PanelWishes {
  std::optional<FileChoice> files;
  std::optional<StageSource> source;
  bool framesAll = false, resets = false, takesScreenshot = false, losesDevice = false;
  bool togglesSettings = false, togglesStatistics = false, togglesHelp = false;
  bool opensFiles = false;
  bool compares = false;                ///< side by side with `right`, or one side again
  std::optional<pelage::Solver> right;  ///< with `compares`
};

/// Builds the panel, which changes the stage. \param title of its bar, which is always visible.
PanelWishes buildStagePanel(Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size, const std::string& title);
/// Builds the key of the view of errors that is shown, in a window of its own at the bottom right.
/// \param besideArrow left of the arrow of the wind.
void buildInspectionKey(const Stage& stage, const WindowSize& size, bool besideArrow);
/// Draws the arrow of the wind, and the line from a lock of hair to the mouse that pulls it.
void drawGizmos(const Stage& stage, const WindowSize& size);

}  // namespace viewer
