// Views of errors: what to show, and the key to its colors.
#pragma once

#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// Builds the choice of a view with its range, in the current window of ImGui.
void buildInspection(Stage& stage);
/// Builds the key of the view that is shown, in a window of its own at the bottom right.
void buildInspectionKey(const Stage& stage, const WindowSize& size);

}  // namespace viewer
