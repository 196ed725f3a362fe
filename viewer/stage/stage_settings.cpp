#include "stage/stage_settings.h"

#include "pelage/assert.h"

namespace viewer {

using pelage::SceneSettings;

namespace {

// Makes the hair again if it was made with other values.
pelage::Result<void> applyMaking(const SceneSettings& settings, size_t hair, Stage& stage) {
  const SceneSettings now = settingsOf(stage, hair);
  SceneSettings wanted = now;
  wanted.creation = settings.creation;
  wanted.follow = settings.follow;
  // A share of simulated guides needs level of detail.
  if (settings.object.simulatedShare < 1) wanted.creation.levelOfDetail = true;
  if (haveSameSettings(now, wanted)) return {};
  return stage.makeHairAgain(hair, {wanted.creation, wanted.follow});
}

}  // namespace

SceneSettings settingsOf(const Stage& stage, size_t hair) {
  PELAGE_ASSERT(hair < stage.hairs().size(), "settingsOf(): the stage has no such hair");
  const pelage::HairObject& object = stage.scene().hair(stage.hairs()[hair]);
  SceneSettings settings;
  settings.simulation = object.settings;
  settings.material = object.material;
  settings.object = settingsOf(object);
  settings.creation = stage.making(hair).creation;
  settings.follow = stage.making(hair).follow;
  if (!stage.colliders().empty())
    settings.collider = settingsOf(stage.scene().collider(stage.colliders()[0]));
  settings.colliderLook = stage.colliderLook;
  settings.contactLook = stage.contactLook;
  settings.lights = stage.lights();
  settings.transparency = stage.transparency.settings();
  settings.view = stage.viewSettings;
  // The next frame gives these values of the look to all hair.
  settings.simulation.wind.velocity = stage.look.wind;
  settings.object.drawnShare = stage.look.strandShare;
  settings.lights[0].shadow = stage.look.shadow;
  settings.transparency.method = stage.look.transparency;
  return settings;
}

pelage::Result<void> apply(const SceneSettings& settings, size_t hair, Stage& stage) {
  PELAGE_ASSERT(hair < stage.hairs().size(), "apply(): the stage has no such hair");
  if (pelage::Result<void> valid = validate(settings); !valid) return valid;
  if (pelage::Result<void> made = applyMaking(settings, hair, stage); !made) return made;
  pelage::HairObject& object = stage.scene().hair(stage.hairs()[hair]);
  object.settings = settings.simulation;
  object.material = settings.material;
  apply(settings.object, object);
  for (const pelage::ColliderId collider : stage.colliders())
    apply(settings.collider, stage.scene().collider(collider));
  stage.colliderLook = settings.colliderLook;
  stage.contactLook = settings.contactLook;
  stage.setLights(settings.lights);
  stage.transparency.set(settings.transparency);
  stage.look.transparency = settings.transparency.method;
  stage.viewSettings = settings.view;
  stage.look.wind = settings.simulation.wind.velocity;
  stage.look.strandShare = settings.object.drawnShare;
  stage.look.shadow = stage.lights()[0].shadow;
  return {};
}

namespace {

// Chooses each side in turn, and calls function().
template <class Function>
void forEachSide(Stage& stage, Function&& function) {
  const uint32_t chosen = stage.side();
  for (uint32_t side = 0; side < stage.sides(); ++side) {
    stage.chooseSide(side);
    function();
  }
  stage.chooseSide(chosen);
}

// Gives settings to hair. \return whether it had others.
bool give(const pelage::SceneSettings& wanted, size_t hair, Stage& stage) {
  if (haveSameSettings(settingsOf(stage, hair), wanted)) return false;
  // They are in range: a frame has run with them, or they are defaults.
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

bool WaysBack::take() {
  bool changed = false;
  for (; !changed && taken_ < 4; ++taken_) {
    if (taken_ == 0) changed = good_.restore(stage_);
    if (taken_ == 1) changed = stage_.resetTarget();
    if (taken_ == 2) changed = stage_.transparency.resetMemory();
    if (taken_ == 3) changed = applyDefaultLook(stage_);
  }
  return changed;
}

}  // namespace viewer
