#include "interface/statistics_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "interface/text.h"

namespace viewer {

using pelage::Result;

namespace {

constexpr float kStatisticsWidth = 400;  // at scale 1
constexpr float kStatisticsHeight = 460;

void memoryLine(uint64_t bytes, const char* what) {
  text(fmt::format("{:8.1f} MiB {}", mebibytes(bytes), what));
}

void buildMemory(const Stage& stage, const Canvas& canvas) {
  const CanvasMemory memory = canvas.memory();
  const pelage::DrawBytes drawn = stage.scene().drawBytes();
  memoryLine(memory.buffers, "in buffers on the device");
  memoryLine(memory.frames, "for constants and uploads");
  for (size_t view = 0; view < drawn.views.size(); ++view)
    memoryLine(drawn.views[view], fmt::format("for view {}", view + 1).c_str());
  memoryLine(drawn.shadows, "for shadow maps");
}

}  // namespace

Result<void> StatisticsPanel::read(const Stage& stage, const pelage::BufferReader& read) {
  if (frames_++ % kReadEvery != 0) return {};
  auto statistics = stage.statistics(read);
  if (!statistics) return statistics.error();
  statistics_ = *std::move(statistics);
  return {};
}

// A click on a pass shows its times of the last frames.
void StatisticsPanel::buildPasses(const PassHistory& history) {
  if (history.totals().empty()) {
    text("the device measures no times");
    return;
  }
  const std::vector<PassHistory::PassTime> passes = history.passes();
  const auto chosen = std::find_if(passes.begin(), passes.end(),
                                   [&](const auto& pass) { return pass.name == pass_; });
  const std::vector<float>& values = chosen == passes.end() ? history.totals() : chosen->frames;
  const float most = *std::max_element(values.begin(), values.end());
  ImGui::PlotLines(
      "##history", values.data(), static_cast<int>(values.size()), 0,
      fmt::format("{}: {:.3f} ms", chosen == passes.end() ? "all" : chosen->name, values.back())
          .c_str(),
      0, std::max(1.2f * most, 1e-3f),
      {ImGui::GetContentRegionAvail().x, 4 * ImGui::GetFontSize()});
  if (ImGui::Selectable("all passes", chosen == passes.end())) pass_.clear();
  for (const PassHistory::PassTime& pass : passes) {
    const std::string line =
        fmt::format("{:8.3f} ms {:2}x {}", pass.milliseconds, pass.passes, pass.name);
    if (ImGui::Selectable(line.c_str(), pass.name == pass_)) pass_ = pass.name;
  }
}

void StatisticsPanel::build(const Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size) {
  const float scale = size.interfaceScale, margin = 8 * scale;
  ImGui::SetNextWindowPos(
      {static_cast<float>(size.width) - kStatisticsWidth * scale - margin, margin},
      ImGuiCond_Appearing);
  ImGui::SetNextWindowSize(
      {kStatisticsWidth * scale,
       std::max(std::min(kStatisticsHeight * scale, static_cast<float>(size.height) - 2 * margin),
                80.0f)},
      ImGuiCond_Appearing);
  if (ImGui::Begin("Statistics")) {
    for (const HairStatistics& hair : statistics_.hairs) {
      text(hair.name);
      for (const std::string& line : linesOf(hair)) text("  " + line);
    }
    for (const ColliderStatistics& collider : statistics_.colliders) text(lineOf(collider));
    if (statistics_.transparency)
      for (const std::string& line :
           linesOf(*statistics_.transparency, stage.transparency().method))
        text(line);
    if (stage.inspection.value == InspectedValue::kTiles)
      for (const std::string& line :
           inspectionKey(stage.inspection, stage.inspected(), stage.look.transparency).lines)
        ImGui::TextWrapped("%s", line.c_str());
    ImGui::Separator();
    buildMemory(stage, canvas);
    ImGui::Separator();
    buildPasses(history);
  }
  ImGui::End();
}

}  // namespace viewer
