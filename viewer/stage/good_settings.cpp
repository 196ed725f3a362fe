#include "stage/good_settings.h"

#include "stage/stage_settings.h"

namespace viewer {

void GoodSettings::keep(Stage& stage) {
  const uint32_t chosen = stage.side();
  for (uint32_t side = 0; side < stage.sides(); ++side) {
    stage.chooseSide(side);
    Side& kept = sides_[side];
    kept.shown = stage.shown();
    kept.hairs.clear();
    for (size_t i = 0; i < stage.hairs().size(); ++i) kept.hairs.push_back(settingsOf(stage, i));
  }
  stage.chooseSide(chosen);
}

bool GoodSettings::restore(Stage& stage) const {
  const Side& kept = sides_[stage.side()];
  if (kept.shown != stage.shown()) return false;
  bool differs = false;
  for (size_t i = 0; i < kept.hairs.size(); ++i) {
    if (haveSameSettings(settingsOf(stage, i), kept.hairs[i])) continue;
    differs = true;
    // They were in range once.
    (void)apply(kept.hairs[i], i, stage);
  }
  return differs;
}

bool applyDefaultLook(Stage& stage) {
  bool differs = false;
  for (size_t i = 0; i < stage.hairs().size(); ++i) {
    const pelage::SceneSettings now = settingsOf(stage, i);
    pelage::SceneSettings wanted = now;
    wanted.material = {};
    wanted.lights = {pelage::Light{}};
    wanted.lights[0].shadow = stage.look.shadow;
    if (haveSameSettings(now, wanted)) continue;
    differs = true;
    (void)apply(wanted, i, stage);
  }
  return differs;
}

}  // namespace viewer
