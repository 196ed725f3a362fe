#include "interface/stage_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "choices.h"
#include "interface/inspection_panel.h"
#include "interface/text.h"

namespace viewer {

namespace {

constexpr float kStageWidth = 250;  // at scale 1
constexpr float kMostWind = 20;     // m/s
constexpr size_t kListedPasses = 14;

template <class T>
bool choose(const char* label, const std::vector<Choice<T>>& choices, T& value) {
  const auto current = std::find_if(choices.begin(), choices.end(),
                                    [&](const Choice<T>& choice) { return choice.value == value; });
  bool changed = false;
  if (!ImGui::BeginCombo(label, current == choices.end() ? "" : current->name)) return false;
  for (const Choice<T>& choice : choices) {
    if (!ImGui::Selectable(choice.name, choice.value == value)) continue;
    changed = value != choice.value;
    value = choice.value;
  }
  ImGui::EndCombo();
  return changed;
}

void buildPlay(Stage& stage, PanelWishes& wishes) {
  PlayClock& clock = stage.clock;
  if (ImGui::Button(clock.playing ? "Pause" : "Play")) clock.playing = !clock.playing;
  ImGui::SameLine();
  if (ImGui::Button("Step")) clock.steps = true;
  ImGui::SameLine();
  wishes.resets = ImGui::Button("Reset");
  ImGui::SameLine();
  wishes.framesAll = ImGui::Button("Frame all");
  ImGui::Checkbox("Loop", &clock.loops);
  ImGui::SameLine();
  text(fmt::format("{:.2f} s", clock.time));
  auto speed = static_cast<float>(clock.speed);
  if (ImGui::SliderFloat("Speed", &speed, 0.05f, 4, "%.2f x", ImGuiSliderFlags_Logarithmic))
    clock.speed = std::clamp(speed, 0.05f, 4.0f);
  if (stage.hasMotions()) choose("Motion", motions(), stage.look.motion);
  wishes.togglesSettings = ImGui::Button("All settings");
  ImGui::SameLine();
  wishes.togglesStatistics = ImGui::Button("Statistics");
}

// The generated hair, or another.
void buildSource(const Stage& stage, PanelWishes& wishes) {
  StageSource source = stage.source();
  const char* current = "character";
  if (source.kind == StageKind::kFiles) current = "files";
  if (source.kind == StageKind::kHead)
    for (const Choice<sample::GroomPreset>& groom : grooms())
      if (groom.value == source.preset) current = groom.name;
  bool changed = false;
  wishes.opensFiles = ImGui::Button("Open files");
  if (ImGui::BeginCombo("Hair", current)) {
    if (ImGui::Selectable("character", source.kind == StageKind::kCharacter)) {
      source.kind = StageKind::kCharacter;
      changed = true;
    }
    for (const Choice<sample::GroomPreset>& groom : grooms()) {
      if (!ImGui::Selectable(groom.name, current == groom.name)) continue;
      source.kind = StageKind::kHead;
      source.preset = groom.value;
      changed = true;
    }
    ImGui::EndCombo();
  }
  changed |= choose("Solver", solvers(), source.solver);
  if (changed) wishes.source = source;
}

// The unit of the files, and one click to another.
void buildFiles(const Stage& stage, PanelWishes& wishes) {
  if (stage.source().kind != StageKind::kFiles) return;
  ImGui::Separator();
  for (const auto& file : stage.source().files) text(file.filename().string());
  text(fmt::format("scale {:g} m per unit", stage.scale()));
  text(fmt::format("mean strand {:.3g} m", stage.meanLength()));
  const auto offer = [&](const char* label, float scale) {
    if (scale == stage.scale()) return;
    if (ImGui::SmallButton(label)) {
      wishes.source = stage.source();
      wishes.source->scale = scale;
    }
    ImGui::SameLine();
  };
  offer("m", 1);
  offer("cm", 0.01f);
  offer("mm", 0.001f);
  offer("inch", 0.0254f);
  ImGui::NewLine();
  for (const std::string& remark : stage.remarks()) ImGui::TextWrapped("%s", remark.c_str());
}

void buildLook(Stage& stage, const Canvas& canvas) {
  pelage::Transparency method = stage.look.transparency;
  if (choose("Method", transparencies(), method) && canvas.supports({.method = method}))
    stage.look.transparency = method;
  choose("Shadow", shadows(), stage.look.shadow);
  float percent = 100 * stage.look.strandShare;
  if (ImGui::SliderFloat("Strands", &percent, 2, 100, "%.0f %%"))
    stage.look.strandShare = std::clamp(percent, 2.0f, 100.0f) / 100;
}

// The wind as a direction in the plan and a speed, and the ball.
void buildForces(Stage& stage) {
  pelage::Float3& wind = stage.look.wind;
  float speed = std::hypot(wind.x, wind.z);
  float angle = speed > 0 ? std::atan2(wind.x, wind.z) : 0;
  const bool stronger = ImGui::SliderFloat("Wind", &speed, 0, kMostWind, "%.1f m/s");
  const bool turned = ImGui::SliderAngle("towards", &angle, -180, 180);
  if (stronger || (turned && speed > 0)) {
    speed = std::clamp(speed, 0.0f, kMostWind);
    wind = {speed * std::sin(angle), wind.y, speed * std::cos(angle)};
  }
  ImGui::Checkbox("Ball", &stage.ball.present);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 6);
  float radius = 100 * stage.ball.radius;
  if (ImGui::SliderFloat("radius", &radius, 1, 20, "%.0f cm"))
    stage.ball.radius = std::clamp(radius, 1.0f, 20.0f) / 100;
}

// Two sides, of which the other windows show the chosen one.
void buildComparison(Stage& stage, PanelWishes& wishes) {
  bool two = stage.sides() == 2;
  pelage::Solver right = stage.solverOf(two ? 1 : 0);
  const bool toggled = ImGui::Checkbox("Side by side", &two);
  if (two && !toggled && choose("Right", solvers(), right)) wishes.compares = true;
  wishes.compares |= toggled;
  if (two) wishes.right = right;
  if (stage.sides() < 2) return;
  int side = static_cast<int>(stage.side());
  ImGui::RadioButton("Edit left", &side, 0);
  ImGui::SameLine();
  ImGui::RadioButton("right", &side, 1);
  stage.chooseSide(static_cast<uint32_t>(side));
}

void buildFigures(const Stage& stage, const Canvas& canvas) {
  uint64_t guides = 0, follow = 0, vertices = 0;
  for (const pelage::HairId id : stage.hairs()) {
    const pelage::HairObject& hair = stage.scene().hair(id);
    guides += hair.guideCount();
    follow += hair.followCount();
    vertices += uint64_t{hair.strandCount()} * hair.verticesPerStrand();
  }
  text(fmt::format("{} guides, {} follow hairs", guides, follow));
  text(fmt::format("{} vertices", vertices));
  const CanvasMemory memory = canvas.memory();
  const pelage::DrawBytes drawn = stage.scene().drawBytes();
  uint64_t views = 0;
  for (const uint64_t bytes : drawn.views) views += bytes;
  const auto line = [](uint64_t bytes, const char* what) {
    text(fmt::format("{:6.1f} MiB {}", mebibytes(bytes), what));
  };
  line(memory.buffers, "in buffers");
  line(views, "of them for the view");
  line(drawn.shadows, "of them for shadows");
}

void buildTimes(const PassHistory& history) {
  if (history.totals().empty()) {
    text("the device measures no times");
    return;
  }
  const float most = *std::max_element(history.totals().begin(), history.totals().end());
  ImGui::PlotLines("##total", history.totals().data(), static_cast<int>(history.totals().size()), 0,
                   fmt::format("{:.2f} ms", history.totals().back()).c_str(), 0, 1.2f * most,
                   {ImGui::GetContentRegionAvail().x, 4 * ImGui::GetFontSize()});
  const std::vector<PassHistory::PassTime> passes = history.passes();
  for (size_t i = 0; i < std::min(passes.size(), kListedPasses); ++i)
    text(fmt::format("{:8.3f} ms {:2}x {}", passes[i].milliseconds, passes[i].passes,
                     passes[i].name));
}

}  // namespace

PanelWishes buildStagePanel(Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size) {
  PanelWishes wishes;
  const float scale = size.interfaceScale, margin = 8 * scale;
  ImGui::SetNextWindowPos({margin, margin}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints(
      {kStageWidth * scale, 0},
      {kStageWidth * scale, std::max(static_cast<float>(size.height) - 2 * margin, 40.0f)});
  ImGui::Begin(
      "pelage", nullptr,
      ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
  ImGui::PushItemWidth(-ImGui::GetFontSize() * 5);
  buildPlay(stage, wishes);
  if (ImGui::CollapsingHeader("Hair", ImGuiTreeNodeFlags_DefaultOpen)) {
    buildSource(stage, wishes);
    buildFiles(stage, wishes);
    buildFigures(stage, canvas);
  }
  if (ImGui::CollapsingHeader("Drawing", ImGuiTreeNodeFlags_DefaultOpen)) buildLook(stage, canvas);
  if (ImGui::CollapsingHeader("Forces", ImGuiTreeNodeFlags_DefaultOpen)) buildForces(stage);
  if (ImGui::CollapsingHeader("Look inside")) {
    buildInspection(stage);
    buildComparison(stage, wishes);
  }
  if (ImGui::CollapsingHeader("GPU times")) buildTimes(history);
  if (ImGui::CollapsingHeader("Device")) {
    ImGui::TextWrapped("%s", canvas.info().name.c_str());
    ImGui::TextWrapped("%s %s", pelage::apiName(canvas.info().api), canvas.info().version.c_str());
    wishes.takesScreenshot = ImGui::Button("Screenshot");
    ImGui::SameLine();
    wishes.losesDevice = ImGui::Button("Lose the device");
  }
  ImGui::PopItemWidth();
  ImGui::End();
  return wishes;
}

}  // namespace viewer
