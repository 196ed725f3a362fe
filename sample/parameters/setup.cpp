#include "setup.h"

#include <cmath>

namespace sample {

namespace {

// Fibers that are seen in a small picture.
void setLook(Setup& setup) {
  setup.hair.material.rootColor = {0.060f, 0.026f, 0.014f};
  setup.hair.material.tipColor = {0.210f, 0.100f, 0.045f};
  setup.hair.material.fiberRadius = 150e-6f;
  setup.transparency.nodeCount = 3000000;
}

}  // namespace

Setup lockSetup() {
  Setup setup;
  setLook(setup);
  setup.follow = {.countPerGuide = 8, .maxRadius = 0.003f};
  setup.center = {0.075f, -0.055f, 0};
  setup.toEye = {0.1f, 0.1f, 1};
  setup.frames = 240;
  return setup;
}

Setup swatchSetup() {
  Setup setup;
  setLook(setup);
  setup.subject = Subject::kSwatch;
  setup.hair.settings.gravity = {};
  setup.hair.material = {};
  setup.hair.material.rootColor = setup.hair.material.tipColor = {0.16f, 0.075f, 0.035f};
  setup.hair.material.fiberRadius = 100e-6f;
  setup.follow = {.countPerGuide = 6, .maxRadius = 0.0015f};
  setup.center = {0, 0.005f, 0.03f};
  setup.toEye = {0, 0.35f, 1};
  setup.extent = 0.13f;
  pelage::Light light;
  light.direction = {0.15f, 0.9f, 0.7f};
  light.color = {1.5f, 1.42f, 1.3f};
  setup.lights = {light};
  return setup;
}

Setup closeSetup() {
  Setup setup = swatchSetup();
  setup.center = {0.055f, 0.012f, 0.052f};
  setup.toEye = {0, 0.1f, 1};
  setup.extent = 0.022f;
  setup.swatchGuides = 130;
  setup.hasRoll = false;
  setup.follow.countPerGuide = 0;
  return setup;
}

Setup headSetup() {
  Setup setup;
  setLook(setup);
  setup.subject = Subject::kHead;
  setup.hair.settings.gravity = {};
  setup.hair.material.fiberRadius = 120e-6f;
  setup.follow = {.countPerGuide = 6, .maxRadius = 0.004f};
  setup.center = {0, 0.195f, 0};
  setup.toEye = {0.55f, 0.18f, 1};
  setup.extent = 0.33f;
  return setup;
}

Setup capsuleSetup() {
  Setup setup = lockSetup();
  setup.lock.direction = {1, 0.25f, 0};
  setup.lock.ballRadius = 0.02f;
  setup.lock.length = 0.2f;
  setup.hair.settings.bendLength = 0.03f;
  pelage::CapsuleCollider capsule;
  capsule.head = {0.085f, -0.06f, 0.05f};
  capsule.tail = {0.085f, -0.06f, -0.05f};
  capsule.headRadius = capsule.tailRadius = 0.045f;
  setup.capsules = {capsule};
  setup.toEye = {0.35f, 0.2f, 1};
  setup.center = {0.075f, -0.06f, 0};
  setup.extent = 0.26f;
  return setup;
}

Setup fieldSetup() {
  Setup setup = capsuleSetup();
  setup.hasField = true;
  setup.collider.cellSize = 0.004f;
  setup.collider.band = 6;
  return setup;
}

Setup sleeveSetup() {
  Setup setup;
  setLook(setup);
  setup.subject = Subject::kSleeve;
  setup.hair.settings.gravity = {};
  setup.hair.material.fiberRadius = 120e-6f;
  setup.follow = {.countPerGuide = 3, .maxRadius = 0.0015f};
  setup.toEye = {0, 0.3f, 1};
  setup.extent = 0.16f;
  setup.motion = [](double) {
    constexpr float kHalfRotation = 1.48f;  // rad, half of what the right side has turned
    return pelage::rigidTransform({std::sin(kHalfRotation), 0, 0, std::cos(kHalfRotation)}, {});
  };
  return setup;
}

}  // namespace sample
