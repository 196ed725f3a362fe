// All windows of the interface: the panel at the left, settings, statistics, help and the file
// dialog.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "canvas/canvas.h"
#include "capture/pass_times.h"
#include "input/event.h"
#include "interface/settings_panel.h"
#include "interface/stage_panel.h"
#include "interface/user_interface.h"
#include "interface/window_layout.h"
#include "stage/files.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

/// The window of statistics: counters, memory, and times of passes with their history.
class StatisticsPanel {
 public:
  static constexpr uint64_t kReadEvery = 30;  ///< frames
  /// Reads the counters every kReadEvery frames; call it after Canvas::show(). Errors: the
  /// device's.
  pelage::Result<void> read(const Stage& stage, const pelage::BufferReader& read);
  void build(const Stage& stage, const Canvas& canvas, const PassHistory& history);

 private:
  void buildPasses(const PassHistory& history);
  StageStatistics statistics_;
  uint64_t frames_ = 0;  // with the window open
  std::string pass_;     // pass whose history is shown; empty: the sum of all
};

/// A dialog that opens files.
class FileDialog {
 public:
  /// Opens it in the folder where it was last, at first the current one; or closes it.
  void toggle();
  /// Builds it if it is open. \return the files that the user has just chosen.
  std::optional<FileChoice> build();
  bool isOpen() const { return isOpen_; }

 private:
  std::optional<FileChoice> takePath();
  void buildEntries();
  void enter(const std::filesystem::path& folder);

  bool isOpen_ = false, wantsFocus_ = false;
  std::filesystem::path folder_;
  std::array<char, 1024> path_ = {};
  FolderList list_;
  std::set<std::string> chosen_;  // names
  std::string error_;
};

/// Frames a second and GPU time of a frame, averaged over half a second.
class FrameTimes {
 public:
  /// Adds a frame. \param seconds since the last one.
  void add(double seconds, const PassHistory& history);
  /// Returns "60 frames/s, GPU 3.21 ms"; without the time where the device measures none.
  const std::string& text() const { return text_; }

 private:
  double seconds_ = 0, gpuMilliseconds_ = 0;
  int frames_ = 0;
  std::string text_;
};

/// All windows, and which of them are open.
class Panels {
 public:
  /// Undoes or redoes an edit with Control and Z or Y, even while a text field has the keys.
  /// \return whether the key does so.
  bool takeShortcut(const KeyPressed& key, Stage& stage);
  /// Opens or closes the window of a key that went down.
  void takeKey(Key key);
  /// Whether the panels are shown at all: Tab hides them.
  bool areShown() const { return areShown_; }
  /// Builds the interface of a frame. \param seconds since the last one.
  PanelWishes build(Stage& stage, const Canvas& canvas, const PassHistory& history,
                    const WindowSize& size, double seconds, UserInterface& interface);
  /// Opens or closes the windows that the user asked for.
  void grant(const PanelWishes& wishes);
  /// Reads the statistics if their window is open; call it after Canvas::show(). Errors: the
  /// device's.
  pelage::Result<void> readStatistics(const Stage& stage, const pelage::BufferReader& read);
  /// Loads settings from a file for the chosen side; an error is a message.
  void loadSettings(const std::filesystem::path& file, Stage& stage, UserInterface& interface);
  /// Mean CPU time of build() [ms].
  double buildMilliseconds() const;

 private:
  std::array<SettingsPanel, 2> settings_;  // [side]
  StatisticsPanel statistics_;
  FileDialog dialog_;
  bool areShown_ = true, showsSettings_ = false, showsStatistics_ = false, showsHelp_ = false;
  WindowLayout layout_;
  FrameTimes times_;
  bool control_ = false;   // its key is down
  double cpuSeconds_ = 0;  // in all builds
  uint64_t buildCount_ = 0;
};

}  // namespace viewer
