// What is drawn over the scene for the mouse: the arrow of the wind, the lock of hair that it
// pulls.
#pragma once

#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// Call it between NewFrame() and Render() of ImGui.
void drawGizmos(const Stage& stage, const WindowSize& size);

}  // namespace viewer
