#include "interface/inspection_panel.h"

#include <imgui.h>

#include <algorithm>

#include "image.h"
#include "interface/text.h"

namespace viewer {

namespace {

constexpr float kKeyWidth = 290;  // at scale 1
constexpr int kSteps = 32;        // of the bar of colors

// As the picture shows a linear color.
ImU32 shownColor(const pelage::Float3& color) {
  pelage::RenderedImage pixel;
  pixel.width = pixel.height = 1;
  pixel.pixels = {{color.x, color.y, color.z, 1}};
  const sample::ByteImage encoded = sample::encodeSrgb(pixel);
  return IM_COL32(encoded.rgb[0], encoded.rgb[1], encoded.rgb[2], 255);
}

void buildRange(InspectionLook& look) {
  const auto slide = [](const char* label, float& value, float low, float high,
                        const char* format) {
    ImGui::SliderFloat(label, &value, low, high, format, ImGuiSliderFlags_Logarithmic);
    value = std::clamp(value, low, high);
  };
  if (look.value == InspectedValue::kStretch) slide("Range", look.stretchRange, 1e-6f, 1, "%.2g");
  if (look.value == InspectedValue::kPenetration)
    slide("Range [m]", look.penetrationRange, 1e-6f, 0.1f, "%.2g");
  if (look.value == InspectedValue::kOverdraw) slide("Range", look.overdrawRange, 1, 1024, "%.0f");
  if (look.value == InspectedValue::kTiles) slide("Range", look.tileRange, 1, 65536, "%.0f");
  if (look.value != InspectedValue::kSdfSlice) return;
  slide("Range [m]", look.sliceRange, 1e-4f, 1, "%.2g");
  int axis = static_cast<int>(look.sliceAxis);
  if (ImGui::Combo("Across", &axis, "x\0y\0z\0")) look.sliceAxis = static_cast<SliceAxis>(axis);
  ImGui::SliderFloat("Position", &look.slicePosition, 0, 1, "%.2f");
  look.slicePosition = std::clamp(look.slicePosition, 0.0f, 1.0f);
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

}  // namespace

void buildInspection(Stage& stage) {
  InspectionLook& look = stage.inspection;
  if (ImGui::BeginCombo("Show", nameOf(look.value))) {
    for (int i = 0; i < kInspectedValues; ++i) {
      const auto value = static_cast<InspectedValue>(i);
      if (ImGui::Selectable(nameOf(value), value == look.value)) look.value = value;
    }
    ImGui::EndCombo();
  }
  buildRange(look);
  ImGui::Checkbox("Contact normals", &stage.look.showsContacts);
}

void buildInspectionKey(const Stage& stage, const WindowSize& size) {
  const InspectionKey key =
      inspectionKey(stage.inspection, stage.inspected(), stage.look.transparency);
  if (key.title.empty()) return;
  const float scale = size.interfaceScale, margin = 8 * scale;
  ImGui::SetNextWindowPos(
      {static_cast<float>(size.width) - margin, static_cast<float>(size.height) - margin},
      ImGuiCond_Always, {1, 1});
  ImGui::SetNextWindowSize({kKeyWidth * scale, 0});
  ImGui::Begin("Key", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  text(key.title);
  if (key.ramp != nullptr) buildBar(key);
  for (const std::string& line : key.lines) ImGui::TextWrapped("%s", line.c_str());
  ImGui::End();
}

}  // namespace viewer
