#include "interface/stage_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "image.h"
#include "interface/user_interface.h"
#include "interface/window_layout.h"
#include "options.h"
#include "stage/controls.h"
#include "stage/environment.h"
#include "stage/orbit_camera.h"

namespace viewer {

namespace {

constexpr ImU32 kColor = IM_COL32(255, 205, 90, 230);
constexpr ImU32 kFaint = IM_COL32(255, 205, 90, 90);

void drawWind(const Stage& stage, const WindowSize& size, ImDrawList& list) {
  const pelage::Float3& wind = stage.look.wind;
  const WindArrow arrow = windArrowOf(stage.camera, wind, size);
  const ImVec2 base = {arrow.base.x, arrow.base.y}, tip = {arrow.tip.x, arrow.tip.y};
  const float scale = size.interfaceScale;
  list.AddCircleFilled(base, 3 * scale, kColor);
  list.AddLine(base, tip, kColor, 2.5f * scale);
  const float x = tip.x - base.x, y = tip.y - base.y, length = std::hypot(x, y);
  if (length > 1) {
    const float ux = x / length * 9 * scale, uy = y / length * 9 * scale;
    list.AddTriangleFilled({tip.x + ux, tip.y + uy}, {tip.x - uy * 0.6f, tip.y + ux * 0.6f},
                           {tip.x + uy * 0.6f, tip.y - ux * 0.6f}, kColor);
  }
  list.AddCircle(tip, arrow.tipRadius, kFaint);
  const std::string text = fmt::format("wind {:.1f} m/s", std::hypot(wind.x, wind.y, wind.z));
  list.AddText({base.x - 40 * scale, static_cast<float>(size.height) - 18 * scale}, kColor,
               text.c_str());
}

void drawPull(const Stage& stage, const WindowSize& size, ImDrawList& list) {
  if (!stage.pull.holds()) return;
  const pelage::View view = stage.camera.view(size.width, size.height);
  const auto from = sample::project(view, stage.pull.point()),
             to = sample::project(view, stage.pull.target());
  if (!from || !to) return;
  list.AddLine({from->x, from->y}, {to->x, to->y}, kFaint, 1.5f * size.interfaceScale);
  list.AddCircle({to->x, to->y}, 6 * size.interfaceScale, kColor);
}

}  // namespace

void drawGizmos(const Stage& stage, const WindowSize& size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  drawWind(stage, size, list);
  drawPull(stage, size, list);
}

namespace {

constexpr float kKeyWidth = 290;  // at scale 1
constexpr int kSteps = 32;        // in the bar of colors

// Encodes a linear color as the picture does.
ImU32 shownColor(const pelage::Float3& color) {
  pelage::RenderedImage pixel;
  pixel.width = pixel.height = 1;
  pixel.pixels = {{color.x, color.y, color.z, 1}};
  const sample::ByteImage encoded = sample::encodeSrgb(pixel);
  return IM_COL32(encoded.rgb[0], encoded.rgb[1], encoded.rgb[2], 255);
}

void buildRange(InspectionLook& look) {
  const auto slide = [](float& value, float low, float high, const char* format) {
    slider("Range", value, low, high, format, true);
  };
  if (look.value == InspectedValue::kStretch) slide(look.stretchRange, 1e-6f, 1, "%.2g");
  if (look.value == InspectedValue::kPenetration)
    slide(look.penetrationRange, 1e-6f, 0.1f, "%.2g m");
  if (look.value == InspectedValue::kOverdraw) slide(look.overdrawRange, 1, 1024, "%.0f");
  if (look.value == InspectedValue::kTiles) slide(look.tileRange, 1, 65536, "%.0f");
  if (look.value != InspectedValue::kSdfSlice) return;
  slide(look.sliceRange, 1e-4f, 1, "%.2g m");
  int axis = static_cast<int>(look.sliceAxis);
  rowName("Across");
  if (ImGui::Combo("##axis", &axis, "x\0y\0z\0")) look.sliceAxis = static_cast<SliceAxis>(axis);
  slider("Position", look.slicePosition, 0, 1, "%.2f");
}

void buildBar(const InspectionKey& key) {
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const ImVec2 size = {ImGui::GetContentRegionAvail().x, ImGui::GetFontSize()};
  for (int i = 0; i < kSteps; ++i) {
    const float share = static_cast<float>(i) / (kSteps - 1);
    const float left = from.x + size.x * static_cast<float>(i) / kSteps;
    ImGui::GetWindowDrawList()->AddRectFilled({left, from.y},
                                              {left + size.x / kSteps + 1, from.y + size.y},
                                              shownColor(colorAt(*key.ramp, 0, 1, share)));
  }
  ImGui::Dummy(size);
  const float left = ImGui::GetCursorPosX();
  text(key.low);
  ImGui::SameLine(left + (size.x - ImGui::CalcTextSize(key.middle.c_str()).x) / 2);
  text(key.middle);
  ImGui::SameLine(left + size.x - ImGui::CalcTextSize(key.high.c_str()).x);
  text(key.high);
}

void buildInspection(Stage& stage) {
  InspectionLook& look = stage.inspection;
  rowName("Show");
  if (ImGui::BeginCombo("##view", nameOf(look.value))) {
    for (int i = 0; i < kInspectedValues; ++i) {
      const auto value = static_cast<InspectedValue>(i);
      if (ImGui::Selectable(nameOf(value), value == look.value)) look.value = value;
    }
    ImGui::EndCombo();
  }
  buildRange(look);
  ImGui::Checkbox("Contact normals", &stage.look.showsContacts);
}

}  // namespace

void buildInspectionKey(const Stage& stage, const WindowSize& size, bool besideArrow) {
  const InspectionKey key =
      inspectionKey(stage.inspection, stage.inspected(), stage.look.transparency);
  if (key.title.empty()) return;
  const float scale = size.interfaceScale, margin = 8 * scale;
  // The arrow points as far to the right as up.
  const float right =
      static_cast<float>(size.width) - (besideArrow ? windArrowHeight(size) : margin);
  ImGui::SetNextWindowPos({right, static_cast<float>(size.height) - margin}, ImGuiCond_Always,
                          {1, 1});
  ImGui::SetNextWindowSize({kKeyWidth * scale, 0});
  ImGui::Begin("Key", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  text(key.title);
  if (key.ramp != nullptr) buildBar(key);
  for (const std::string& line : key.lines) ImGui::TextWrapped("%s", line.c_str());
  ImGui::End();
}

namespace {

constexpr float kMostWind = 20;   // m/s
constexpr float kHalfTurn = 180;  // degrees
constexpr size_t kListedPasses = 14;

template <class T, size_t N>
bool choose(const char* label, const Choice<T> (&choices)[N], T& value) {
  const auto* const current =
      std::find_if(std::begin(choices), std::end(choices),
                   [&](const Choice<T>& choice) { return choice.value == value; });
  bool changed = false;
  rowName(label);
  const std::string id = std::string("##") + label;
  if (!ImGui::BeginCombo(id.c_str(), current == std::end(choices) ? "" : current->name))
    return false;
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
  if (slider("Speed", speed, 0.05f, 4, "%.2f x", true)) clock.speed = speed;
  if (stage.hasMotions()) choose("Motion", kMotions, stage.look.motion);
  wishes.togglesSettings = ImGui::Button("All settings");
  ImGui::SameLine();
  wishes.togglesStatistics = ImGui::Button("Statistics");
  ImGui::SameLine();
  wishes.togglesHelp = ImGui::Button("F1: help");
}

// Builds the choice of generated hair and of the solver.
void buildSource(const Stage& stage, PanelWishes& wishes) {
  StageSource source = stage.source();
  const char* current = "character";
  if (source.kind == StageKind::kFiles) current = "files";
  if (source.kind == StageKind::kHead)
    for (const Choice<sample::GroomPreset>& groom : kGrooms)
      if (groom.value == source.preset) current = groom.name;
  bool changed = false;
  wishes.opensFiles = ImGui::Button("Open files");
  rowName("Hair");
  if (ImGui::BeginCombo("##hair", current)) {
    if (ImGui::Selectable("character", source.kind == StageKind::kCharacter)) {
      source.kind = StageKind::kCharacter;
      changed = true;
    }
    for (const Choice<sample::GroomPreset>& groom : kGrooms) {
      if (!ImGui::Selectable(groom.name, current == groom.name)) continue;
      source.kind = StageKind::kHead;
      source.preset = groom.value;
      changed = true;
    }
    ImGui::EndCombo();
  }
  changed |= choose("Solver", kSolvers, source.solver);
  if (changed) wishes.source = source;
}

// Shows the unit of the files, with a button for each other unit.
void buildFiles(const Stage& stage, PanelWishes& wishes) {
  if (stage.source().kind != StageKind::kFiles) return;
  ImGui::Separator();
  for (const auto& file : stage.source().files) text(file.filename().string());
  text(fmt::format("scale {:g} m per unit", stage.files().scale));
  text(fmt::format("mean strand {:.3g} m", stage.files().meanLength));
  const auto offer = [&](const char* label, float scale) {
    if (scale == stage.files().scale) return;
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
  for (const std::string& remark : stage.files().remarks) ImGui::TextWrapped("%s", remark.c_str());
}

void buildLook(Stage& stage, const Canvas& canvas) {
  pelage::Transparency method = stage.look.transparency;
  if (choose("Method", kTransparencies, method) && canvas.supports({.method = method}))
    stage.look.transparency = method;
  choose("Shadow", kShadows, stage.look.shadow);
  float percent = 100 * stage.look.strandShare;
  if (slider("Strands", percent, 2, 100, "%.0f %%")) stage.look.strandShare = percent / 100;
  slider("Detail", stage.look.detailPixels, 0, 1, "%.2f pixels");
  rowName("Sky");
  if (ImGui::BeginCombo("##environment", environmentName(stage))) {
    if (ImGui::Selectable(kOwnEnvironment)) setEnvironment(stage.ownEnvironment(), stage);
    for (const NamedEnvironment& one : environments())
      if (ImGui::Selectable(one.name)) setEnvironment(one.light, stage);
    ImGui::EndCombo();
  }
  ImGui::Checkbox("Ground", &stage.look.showsGround);
}

// Builds the wind, as a speed and a horizontal direction, and the ball.
void buildForces(Stage& stage) {
  pelage::Float3& wind = stage.look.wind;
  float speed = std::hypot(wind.x, wind.y, wind.z);
  constexpr float kDegree = std::numbers::pi_v<float> / kHalfTurn;
  float angle = speed > 0 ? std::atan2(wind.x, wind.z) / kDegree : 0;
  const bool stronger = slider("Wind", speed, 0, kMostWind, "%.1f m/s");
  const bool turned = slider("Towards", angle, -kHalfTurn, kHalfTurn, "%.0f\xc2\xb0");
  if (stronger || (turned && speed > 0)) wind = turnedWind(wind, speed, angle * kDegree);
  ImGui::Checkbox("Ball", &stage.ball.present);
  float radius = 100 * stage.ball.radius;
  if (slider("Radius", radius, 1, 20, "%.0f cm")) stage.ball.radius = radius / 100;
}

// Builds the comparison of two sides; the other windows show the chosen side.
void buildComparison(Stage& stage, PanelWishes& wishes) {
  bool two = stage.sides() == 2;
  pelage::Solver right = stage.solverOf(two ? 1 : 0);
  const bool toggled = ImGui::Checkbox("Side by side", &two);
  if (two && !toggled && choose("Right", kSolvers, right)) wishes.compares = true;
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
    textWithValue(what, fmt::format("{:.1f} MiB", mebibytes(bytes)));
  };
  line(memory.buffers, "Buffers");
  line(views, "  of the view");
  line(drawn.shadows, "  of shadows");
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
    textWithValue(passes[i].name, fmt::format("{:.3f} ms", passes[i].milliseconds));
}

}  // namespace

PanelWishes buildStagePanel(Stage& stage, const Canvas& canvas, const PassHistory& history,
                            const WindowSize& size, const std::string& title) {
  PanelWishes wishes;
  const float scale = size.interfaceScale, margin = 8 * scale;
  ImGui::SetNextWindowPos({margin, margin}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints(
      {kPanelWidth * scale, 0},
      {kPanelWidth * scale, std::max(static_cast<float>(size.height) - 2 * margin, 40.0f)});
  ImGui::Begin(
      (title + "###pelage").c_str(), nullptr,
      ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
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
  ImGui::End();
  return wishes;
}

}  // namespace viewer
