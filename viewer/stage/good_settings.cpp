#include "stage/good_settings.h"

#include "stage/stage_settings.h"

namespace viewer {

namespace {

// Calls function() for each side, which is chosen meanwhile.
template <class Function>
void forEachSide(Stage& stage, Function&& function) {
  const uint32_t chosen = stage.side();
  for (uint32_t side = 0; side < stage.sides(); ++side) {
    stage.chooseSide(side);
    function();
  }
  stage.chooseSide(chosen);
}

// \return whether the hair had others.
bool give(const pelage::SceneSettings& wanted, size_t hair, Stage& stage) {
  if (haveSameSettings(settingsOf(stage, hair), wanted)) return false;
  // They were in range once.
  (void)apply(wanted, hair, stage);
  return true;
}

}  // namespace

void GoodSettings::keep(Stage& stage) {
  forEachSide(stage, [&] {
    Side& kept = sides_[stage.side()];
    kept.shown = stage.shown();
    kept.hairs.clear();
    for (size_t i = 0; i < stage.hairs().size(); ++i) kept.hairs.push_back(settingsOf(stage, i));
  });
}

bool GoodSettings::restore(Stage& stage) const {
  bool differs = false;
  forEachSide(stage, [&] {
    const Side& kept = sides_[stage.side()];
    if (kept.shown != stage.shown()) return;
    for (size_t i = 0; i < kept.hairs.size(); ++i)
      if (give(kept.hairs[i], i, stage)) differs = true;
  });
  return differs;
}

bool applyDefaultLook(Stage& stage) {
  bool differs = false;
  forEachSide(stage, [&] {
    for (size_t i = 0; i < stage.hairs().size(); ++i) {
      pelage::SceneSettings wanted = settingsOf(stage, i);
      wanted.material = {};
      wanted.lights = {pelage::Light{}};
      wanted.lights[0].shadow = stage.look.shadow;
      if (give(wanted, i, stage)) differs = true;
    }
  });
  return differs;
}

}  // namespace viewer
