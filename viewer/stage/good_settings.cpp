#include "stage/good_settings.h"

#include "stage/stage_settings.h"

namespace viewer {

void GoodSettings::keep(const Stage& stage) {
  shown_ = stage.shown();
  hairs_.clear();
  for (size_t i = 0; i < stage.hairs().size(); ++i) hairs_.push_back(settingsOf(stage, i));
}

bool GoodSettings::restore(Stage& stage) const {
  if (shown_ != stage.shown()) return false;
  bool differs = false;
  for (size_t i = 0; i < hairs_.size(); ++i) {
    if (haveSameSettings(settingsOf(stage, i), hairs_[i])) continue;
    differs = true;
    // They were in range once.
    (void)apply(hairs_[i], i, stage);
  }
  return differs;
}

}  // namespace viewer
