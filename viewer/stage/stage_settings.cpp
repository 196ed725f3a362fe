#include "stage/stage_settings.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "pelage/assert.h"

namespace viewer {

using pelage::SceneSettings;

namespace {

constexpr std::string_view kSections[] = {"simulation",   "material", "object",      "creation",
                                          "follow",       "collider", "contactLook", "lights",
                                          "transparency", "view"};

// What was made with other values is made again.
pelage::Result<void> applyMaking(const SceneSettings& settings, size_t hair, Stage& stage) {
  const SceneSettings now = settingsOf(stage, hair);
  SceneSettings wanted = now;
  wanted.creation = settings.creation;
  wanted.follow = settings.follow;
  // A share of the simulated guides needs it.
  if (settings.object.simulatedShare < 1) wanted.creation.levelOfDetail = true;
  if (haveSameSettings(now, wanted)) return {};
  return stage.makeHairAgain(hair, {wanted.creation, wanted.follow});
}

}  // namespace

uint32_t stageSections() {
  uint32_t bits = 0;
  const auto all = pelage::settingsSections();
  for (size_t s = 0; s < all.size(); ++s)
    if (std::find(std::begin(kSections), std::end(kSections), all[s].key) != std::end(kSections))
      bits |= 1u << s;
  return bits;
}

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
  settings.contactLook = stage.contactLook;
  settings.lights = stage.lights();
  settings.transparency = stage.transparency();
  settings.view = stage.viewSettings;
  // What the next frame gives to all hair.
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
  stage.contactLook = settings.contactLook;
  stage.setLights(settings.lights);
  stage.setTransparency(settings.transparency);
  stage.viewSettings = settings.view;
  stage.look.wind = settings.simulation.wind.velocity;
  stage.look.strandShare = settings.object.drawnShare;
  stage.look.shadow = stage.lights()[0].shadow;
  return {};
}

}  // namespace viewer
