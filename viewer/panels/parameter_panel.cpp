#include "parameter_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cctype>

#include "pelage/settings/settings_file.h"
#include "value_widget.h"

namespace viewer {
namespace {

using pelage::Parameter;
using pelage::ParameterValue;
using pelage::SceneSettings;
using pelage::SettingsSection;

const ImVec4 kChangedColor = {1.0f, 0.75f, 0.3f, 1.0f};
constexpr float kWidgetShare = 0.5f;        // of the panel's width
constexpr float kNameShare = 0.38f;         // likewise
constexpr const char* kReset = "\xc3\x97";  // a cross

bool contains(std::string_view text, std::string_view part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

pelage::Float2 point(const ImVec2& at) { return {at.x, at.y}; }

const SettingsSection& section(size_t s) { return pelage::settingsSections()[s]; }

bool isChanged(const SceneSettings& settings, size_t s, size_t index, const Parameter& parameter) {
  return !haveSameBits(section(s).get(settings, parameter, index), parameter.defaultValue);
}

// Whether a parameter passes the search and the filter of changed ones.
bool isShown(const ParameterPanel& panel, const SceneSettings& settings, size_t s, size_t index,
             const Parameter& parameter) {
  if (panel.onlyChanged && !isChanged(settings, s, index, parameter)) return false;
  const std::string_view part = panel.search;
  return part.empty() || contains(parameter.path, part) || contains(parameter.owner, part) ||
         contains(wordsOf(parameter.field), part) || contains(parameter.meaning, part) ||
         contains(parameter.unit, part) || contains(section(s).title, part);
}

// Keeps the inner angle of a cone at most at the outer one: the angle that was not edited gives
// way.
void keepCone(const Parameter& parameter, pelage::Light& light) {
  if (parameter.path == "innerConeAngle")
    light.outerConeAngle = std::max(light.outerConeAngle, light.innerConeAngle);
  else
    light.innerConeAngle = std::min(light.innerConeAngle, light.outerConeAngle);
}

bool isUsed(const SceneSettings& settings, const Parameter& parameter) {
  const bool exact = settings.simulation.solver == pelage::Solver::kExact;
  return parameter.solver.empty() || parameter.solver == (exact ? "exact" : "classic");
}

void drawTooltip(const Parameter& parameter) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
  ImGui::TextUnformatted(tooltipText(parameter).c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

/// Draws the panel once.
class Drawing {
 public:
  Drawing(ParameterPanel& panel, SceneSettings& settings) : panel_(panel), settings_(settings) {
    panel_.items.clear();
    panel_.buttons.clear();
  }

  PanelChange run() {
    drawTop();
    const auto sections = pelage::settingsSections();
    for (size_t s = 0; s < sections.size(); ++s) {
      if (sections[s].isList)
        drawList(s);
      else
        drawGroup(s, 0, std::string(sections[s].title));
    }
    panel_.openAll = false;
    // An edit is finished when the user releases the slider.
    if (change_.changed()) panel_.unfinished = true;
    if (panel_.unfinished && !ImGui::IsAnyItemActive()) {
      panel_.unfinished = false;
      change_.finished = true;
    }
    return change_;
  }

 private:
  void note(size_t s) { change_.sections |= 1u << s; }

  void drawTop() {
    const auto presets = pelage::settingsPresets();
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * kWidgetShare);
    const std::string newest(
        panel_.newestPreset < presets.size() ? presets[panel_.newestPreset].name : "choose");
    if (ImGui::BeginCombo("Preset", newest.c_str())) {
      for (size_t i = 0; i < presets.size(); ++i) {
        if (ImGui::Selectable(std::string(presets[i].name).c_str())) takePreset(i);
        if (ImGui::IsItemHovered())
          ImGui::SetTooltip("%s", std::string(presets[i].meaning).c_str());
      }
      ImGui::EndCombo();
    }
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * kWidgetShare);
    ImGui::InputTextWithHint("##search", "search", panel_.search, sizeof panel_.search);
    ImGui::SameLine();
    ImGui::Checkbox("Changed only", &panel_.onlyChanged);
  }

  // Takes the settings of a kind of hair; lights and views stay.
  void takePreset(size_t index) {
    panel_.newestPreset = index;
    const auto preset = pelage::presetSettings(pelage::settingsPresets()[index].name);
    if (!preset) return;
    const auto sections = pelage::settingsSections();
    for (size_t s = 0; s < sections.size(); ++s) {
      const std::string_view key = sections[s].key;
      if (key != "simulation" && key != "material" && key != "follow") continue;
      for (const Parameter& p : sections[s].parameters)
        sections[s].set(settings_, p, sections[s].get(*preset, p));
      note(s);
    }
  }

  void drawList(size_t s) {
    for (size_t i = 0; i < settings_.lights.size(); ++i)
      drawGroup(s, i, fmt::format("{} {}", section(s).title, i + 1));
    if (settings_.lights.size() >= pelage::kMaxLights || !button("Add light", s, 0)) return;
    settings_.lights.emplace_back();
    note(s);
  }

  bool button(const char* label, size_t s, size_t index) {
    const bool pressed = ImGui::SmallButton(label);
    panel_.buttons.push_back({label, &section(s), index, point(ImGui::GetItemRectMin()),
                              point(ImGui::GetItemRectMax())});
    return pressed;
  }

  // Draws a group; its header says how many values differ from their defaults.
  void drawGroup(size_t s, size_t index, const std::string& title) {
    size_t shown = 0, changed = 0;
    for (const Parameter& parameter : section(s).parameters) {
      shown += isShown(panel_, settings_, s, index, parameter) ? 1 : 0;
      changed += isChanged(settings_, s, index, parameter) ? 1 : 0;
    }
    if (shown == 0) return;
    const bool filtered = panel_.search[0] != 0 || panel_.onlyChanged;
    if (panel_.openAll || filtered) ImGui::SetNextItemOpen(true);
    const std::string head =
        changed == 0 ? fmt::format("{}###{}{}", title, section(s).key, index)
                     : fmt::format("{} ({} changed)###{}{}", title, changed, section(s).key, index);
    ImGui::PushID(std::string(section(s).key).c_str());
    ImGui::PushID(static_cast<int>(index));
    if (ImGui::CollapsingHeader(head.c_str(), s == 0 ? ImGuiTreeNodeFlags_DefaultOpen : 0)) {
      drawValues(s, index);
      drawGroupButtons(s, index, changed);
    }
    ImGui::PopID();
    ImGui::PopID();
  }

  void drawValues(size_t s, size_t index) {
    std::string_view before;
    for (const Parameter& parameter : section(s).parameters) {
      if (!isShown(panel_, settings_, s, index, parameter)) continue;
      const std::string_view inside =
          parameter.path.substr(0, parameter.path.size() - parameter.field.size());
      if (inside != before && !inside.empty())
        ImGui::TextDisabled("%.*s", static_cast<int>(inside.size() - 1), inside.data());
      before = inside;
      ImGui::PushID(&parameter);
      drawValue(s, index, parameter);
      ImGui::PopID();
    }
  }

  void drawValue(size_t s, size_t index, const Parameter& parameter) {
    PanelItem item = {.section = &section(s),
                      .parameter = &parameter,
                      .index = index,
                      .isChanged = isChanged(settings_, s, index, parameter),
                      .isUsed = isUsed(settings_, parameter)};
    ParameterValue value = section(s).get(settings_, parameter, index);
    bool edited = drawName(item);
    if (edited) value = parameter.defaultValue;
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    ImGui::BeginDisabled(!item.isUsed);
    edited |= editValue(parameter, value);
    ImGui::EndDisabled();
    item.min = point(ImGui::GetItemRectMin());
    item.max = point(ImGui::GetItemRectMax());
    drawTooltip(parameter);
    panel_.items.push_back(item);
    if (!edited) return;
    section(s).set(settings_, parameter, value, index);
    if (section(s).isList) keepCone(parameter, settings_.lights[index]);
    note(s);
  }

  // Draws the name, and a button that resets a changed value, in the left column. \return whether
  // the button was pressed.
  static bool drawName(PanelItem& item) {
    const float left = ImGui::GetCursorPosX();
    const float column = ImGui::GetWindowContentRegionMax().x * kNameShare;
    const std::string name = wordsOf(item.parameter->field);
    ImGui::AlignTextToFramePadding();
    ImGui::BeginDisabled(!item.isUsed);
    if (item.isChanged)
      ImGui::TextColored(kChangedColor, "%s", name.c_str());
    else
      ImGui::TextUnformatted(name.c_str());
    ImGui::EndDisabled();
    drawTooltip(*item.parameter);
    bool pressed = false;
    if (item.isChanged) {
      ImGui::SameLine(left + column - ImGui::GetFrameHeight());
      pressed = ImGui::SmallButton(kReset);
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("Reset");
      item.resetMin = point(ImGui::GetItemRectMin());
      item.resetMax = point(ImGui::GetItemRectMax());
    }
    ImGui::SameLine(left + column);
    return pressed;
  }

  void drawGroupButtons(size_t s, size_t index, size_t changed) {
    if (changed > 0 && button("Reset group", s, index)) {
      for (const Parameter& parameter : section(s).parameters)
        section(s).set(settings_, parameter, parameter.defaultValue, index);
      note(s);
    }
    if (!section(s).isList) return;
    if (changed > 0) ImGui::SameLine();
    if (!button("Remove light", s, index)) return;
    settings_.lights.erase(settings_.lights.begin() + static_cast<ptrdiff_t>(index));
    note(s);
  }

  ParameterPanel& panel_;
  SceneSettings& settings_;
  PanelChange change_;
};

}  // namespace

bool PanelChange::changed(std::string_view key) const {
  const auto all = pelage::settingsSections();
  for (size_t s = 0; s < all.size(); ++s)
    if (all[s].key == key) return (sections >> s & 1u) != 0;
  return false;
}

PanelChange drawParameters(ParameterPanel& panel, SceneSettings& settings) {
  return Drawing(panel, settings).run();
}

}  // namespace viewer
