// The window with all settings of what is on the stage: edited, undone, loaded and saved.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "history/edit_history.h"
#include "panels/parameter_panel.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// A message that the user should read.
struct SettingsMessage {
  std::string title, text;
};

class SettingsPanel {
 public:
  /// Draws the window, and gives the stage what changed. \return messages of files that cannot be
  /// read or written.
  std::vector<SettingsMessage> build(Stage& stage, const WindowSize& size);

  /// Sets what a file has, for all hair. Errors: SettingsFile's; nothing is set then.
  pelage::Result<void> load(const std::filesystem::path& file, Stage& stage);
  /// Goes to the settings before the last edit of the chosen hair, or after it. Nothing happens
  /// where there are none.
  void undo(Stage& stage);
  void redo(Stage& stage);
  /// Of the chosen hair: index in Stage::hairs().
  size_t hair() const { return hair_; }

 private:
  void follow(const Stage& stage);
  void buildHair(const Stage& stage);
  void buildFile(Stage& stage, std::vector<SettingsMessage>& messages);

  ParameterPanel panel_;
  uint64_t shown_ = 0;                  ///< Stage::shown() that the histories belong to
  std::vector<EditHistory> histories_;  ///< [hair]
  size_t hair_ = 0;
  char file_[512] = "settings.json";
};

}  // namespace viewer
