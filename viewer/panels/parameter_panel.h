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
  pelage::Float2 resetMin = {}, resetMax = {};  ///< of the button that resets it
  bool isChanged = false;                       ///< it differs from its default
};

/// A button of the last draw: "Reset group", "Remove light" or "Add light".
struct PanelButton {
  std::string_view label;
  const pelage::SettingsSection* section = nullptr;
  size_t index = 0;  ///< of a light
  pelage::Float2 min = {}, max = {};
};

/// What the panel remembers between frames.
struct ParameterPanel {
  char search[64] = {};      ///< shows parameters with this in name, unit or sentence
  bool onlyChanged = false;  ///< shows those that differ from their default
  bool openAll = false;      ///< opens all groups in the next draw
  uint32_t sections = ~0u;   ///< bit i: the i-th of pelage::settingsSections() is drawn
  bool unfinished = false;   ///< the user holds a slider that has moved
  /// Index in pelage::settingsPresets() of the one that was chosen last; ~0: none.
  size_t newestPreset = ~size_t{0};
  std::vector<PanelItem> items;
  std::vector<PanelButton> buttons;
};

/// What a draw did to the settings.
struct PanelChange {
  uint32_t sections = 0;  ///< bit i: the i-th of pelage::settingsSections() changed
  /// The edit is done: no slider is held any more. Add the settings to the history.
  bool finished = false;

  bool changed() const { return sections != 0; }
  /// Whether a section changed, by its key: "creation".
  bool changed(std::string_view key) const;
};

/// Draws the panel into the current window: presets, a search field, and a group for each section.
/// Settings that are in range (pelage::validate()) stay so. Widths adapt to the window.
PanelChange drawParameters(ParameterPanel& panel, pelage::SceneSettings& settings);

}  // namespace viewer
