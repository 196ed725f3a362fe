// The panel of all parameters, drawn by Dear ImGui from the table of pelage::settings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "pelage/settings/scene_settings.h"
#include "pelage/types.h"

namespace viewer {

/// A widget of the last draw, in pixels of the screen: for tests and for tours of the panel.
struct PanelItem {
  const pelage::SettingsSection* section = nullptr;
  const pelage::Parameter* parameter = nullptr;
  size_t index = 0;                             ///< of a light
  pelage::Float2 min = {}, max = {};            ///< of the widget that sets the value
  pelage::Float2 resetMin = {}, resetMax = {};  ///< of the reset button
  bool isChanged = false;                       ///< it differs from its default
  bool isUsed = true;                           ///< by the chosen solver; else it is grayed
};

/// A button of the last draw: "Reset group", "Remove light" or "Add light".
struct PanelButton {
  std::string_view label;
  const pelage::SettingsSection* section = nullptr;
  size_t index = 0;  ///< of a light
  pelage::Float2 min = {}, max = {};
};

/// The state of the panel between frames.
struct ParameterPanel {
  char search[64] = {};      ///< shows parameters with this text in name, unit or meaning
  bool onlyChanged = false;  ///< shows parameters that differ from their defaults
  bool openAll = false;      ///< opens all groups in the next draw
  bool unfinished = false;   ///< the user still holds a slider that has moved
  /// Index of the last chosen preset in pelage::settingsPresets(); ~0: none.
  size_t newestPreset = ~size_t{0};
  std::vector<PanelItem> items;
  std::vector<PanelButton> buttons;
};

/// The changes that a draw made to the settings.
struct PanelChange {
  uint32_t sections = 0;  ///< bit i: the i-th of pelage::settingsSections() changed
  /// The edit is done: add the settings to the history.
  bool finished = false;

  bool changed() const { return sections != 0; }
  /// Whether a section changed, by its key: "creation".
  bool changed(std::string_view key) const;
};

/// Draws the panel into the current window: presets, a search field, and a group for each section.
/// Settings in range (pelage::validate()) stay in range. Widths adapt to the window.
PanelChange drawParameters(ParameterPanel& panel, pelage::SceneSettings& settings);

}  // namespace viewer
