// Text in the current window of ImGui.
#pragma once

#include <imgui.h>

#include <string>

namespace viewer {

inline void text(const std::string& line) { ImGui::TextUnformatted(line.c_str()); }

}  // namespace viewer
