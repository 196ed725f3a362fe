#include "interface/help.h"

#include <imgui.h>

namespace viewer {

namespace {

constexpr HelpLine kLines[] = {
    {"F1", "opens or closes this help"},
    {"left button", "orbits"},
    {"right or middle button, or Shift and left", "moves the camera sideways"},
    {"wheel", "comes nearer, goes away"},
    {"Alt (or G) and left", "pulls the lock of hair under the mouse"},
    {"left at the tip of the arrow", "sets the wind: direction in the picture, and strength"},
    {"Control and left", "drags a ball through the hair; the wheel moves it away and nearer"},
    {"F", "frames all"},
    {"Control and 1 to 9", "keeps the camera"},
    {"1 to 9", "goes to a camera that was kept"},
    {"Space", "plays, pauses"},
    {".", "takes a single step of 1/60 s"},
    {"-, =", "half as fast, twice as fast: 1/16 to 4 times"},
    {"R", "puts the hair into its bind shape, and the motion to its beginning"},
    {"L", "starts over at the end of the motion, or stops there"},
    {"B", "takes the ball away"},
    {"C", "shows the contacts of the guides"},
    {"S", "opens or closes the window of all settings"},
    {"V, Shift and V", "shows the next view of errors, or the one before"},
    {"I", "opens or closes the statistics"},
    {"D", "shows the other solver side by side, or one side again"},
    {"E", "edits the other side"},
    {"O", "opens files"},
    {"Control and Z, Y", "undoes and redoes an edit of the settings"},
    {"Tab", "hides or shows the panels"},
    {"F8", "begins and ends pelage-NNNN.csv with the GPU times of all passes"},
    {"F10", "begins and ends a video pelage-NNNN.mp4, or a folder of pictures without ffmpeg"},
    {"F12", "saves pelage-NNNN.png in the current folder"},
    {"F9", "loses the device and makes another one"},
};

}  // namespace

std::span<const HelpLine> helpLines() { return kLines; }

bool buildHelp() {
  bool open = true;
  if (ImGui::Begin("Keys and mouse", &open, ImGuiWindowFlags_NoCollapse) &&
      ImGui::BeginTable("keys", 2, ImGuiTableFlags_RowBg)) {
    for (const HelpLine& line : kLines) {
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", line.keys);
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", line.action);
    }
    ImGui::EndTable();
  }
  ImGui::End();
  return open;
}

}  // namespace viewer
