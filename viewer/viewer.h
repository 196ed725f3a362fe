// The program: joins input, stage, panels and captures.
#pragma once

#include <chrono>
#include <filesystem>
#include <utility>
#include <vector>

#include "capture/captures.h"
#include "input/event.h"
#include "input/script.h"
#include "interface/panels.h"
#include "options.h"
#include "pelage/result.h"
#include "presentation.h"
#include "stage/controls.h"
#include "window/window.h"

namespace viewer {

/// Times of a session; those of its start are for Options::printsStart.
struct SessionTimes {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now(), lastFrame = start;
  double opened = 0, shown = 0, firstPicture = 0;  ///< [s] since `start`
};

class Viewer {
 public:
  explicit Viewer(Options options)
      : options_(std::move(options)),
        captures_(options_.captures, !options_.script.empty(), options_.fixedClock) {}
  /// Opens the window and shows the source of the options. A source that cannot be shown is a
  /// message in the window. Errors: no display, no device; a script that cannot be read.
  pelage::Result<void> open();
  /// Runs until the user quits. Errors: the device fails and does not come back; a screenshot of a
  /// script that cannot be written; messages of the validation.
  pelage::Result<void> run();

 private:
  pelage::Result<void> take(const Event& event);
  void takeKey(Key key);
  void drop(std::vector<std::filesystem::path> files, bool adds);
  pelage::Result<void> drawFrame(const WindowSize& size);
  pelage::Result<void> grant(const PanelWishes& wishes);

  Options options_;
  Presentation shown_;
  SessionInput input_;
  StageControls controls_;
  Panels panels_;
  Captures captures_;
  SessionTimes times_;
};

}  // namespace viewer
