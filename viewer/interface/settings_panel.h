// The window that edits, undoes, loads and saves all settings of the stage.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "panels/edit_history.h"
#include "panels/parameter_panel.h"
#include "stage/stage.h"

namespace viewer {

/// A message that the user should read.
struct SettingsMessage {
  std::string title, text;
};

class SettingsPanel {
 public:
  /// Draws the window, and applies edits to the stage. \return messages about files that cannot be
  /// read or written.
  std::vector<SettingsMessage> build(Stage& stage);

  /// Sets the settings of a file for all hair. Errors: SettingsFile's; nothing is set then.
  pelage::Result<void> load(const std::filesystem::path& file, Stage& stage);
  /// Undoes or redoes the last edit of the chosen hair, if there is one.
  void undo(Stage& stage);
  void redo(Stage& stage);

 private:
  void follow(const Stage& stage);
  void buildHair(const Stage& stage);
  void buildFile(Stage& stage, std::vector<SettingsMessage>& messages);

  ParameterPanel panel_;
  uint64_t shown_ = 0;                  ///< Stage::shown() that the histories belong to
  std::vector<EditHistory> histories_;  ///< [hair]
  size_t hair_ = 0;                     ///< the chosen one: index in Stage::hairs()
  char file_[512] = "settings.json";
};

}  // namespace viewer
