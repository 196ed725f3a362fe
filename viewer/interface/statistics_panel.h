// The window of statistics: counters, memory, and times of passes with their history.
#pragma once

#include <string>

#include "canvas/canvas.h"
#include "interface/pass_history.h"
#include "stage/stage.h"
#include "window/window.h"

namespace viewer {

class StatisticsPanel {
 public:
  static constexpr uint64_t kReadEvery = 30;  ///< frames
  /// Reads the counters every some frames; call it behind Canvas::show(). Errors: the device's.
  pelage::Result<void> read(const Stage& stage, const pelage::BufferReader& read);
  void build(const Stage& stage, const Canvas& canvas, const PassHistory& history,
             const WindowSize& size);

 private:
  void buildPasses(const PassHistory& history);
  StageStatistics statistics_;
  uint64_t frames_ = 0;  // since it was opened
  std::string pass_;     // whose history is shown; empty: that of all together
};

}  // namespace viewer
