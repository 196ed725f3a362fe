// A scene whose frames are alike, with all that has a history: for tests that count what a frame
// allocates.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "pelage/scene.h"
#include "support/counted_new.h"
#include "support/delivery_scene.h"
#include "support/views.h"

namespace pelage::test {

/// Hair objects of both solvers in turn, half of them on one skeleton, with capsules, mesh
/// colliders, hair-hair contact, wind, sleep, levels of detail, motion and interpolation.
class SteadyScene {
 public:
  static constexpr int kWarmUp = 18, kFrames = 6;

  SteadyScene(Scene& scene, uint32_t objects) : scene_(scene) {
    const Result<SkeletonId> skeleton = scene.addSkeleton({.name = "walker", .boneCount = 2});
    EXPECT_TRUE(skeleton);
    skeleton_ = *skeleton;
    EXPECT_TRUE(
        scene.addCollider(twoBoxes(), {.name = "mesh", .cellSize = 0.02f, .skeleton = skeleton_}));
    const auto asset = std::make_shared<const HairAsset>(makeAsset(6));
    std::vector<FollowHair> follows(6);
    for (uint32_t i = 0; i < 6; ++i) follows[i] = {.guide = i, .offset = {0.004f, 0, 0.003f, 1.5f}};
    for (uint32_t i = 0; i < objects; ++i) {
      SimulationSettings settings;
      const bool exact = i % 4 < 2;
      settings.solver = exact ? Solver::kExact : Solver::kClassic;
      settings.wind.velocity = {0, 0, 0.5f};
      if (exact) settings.contact.stiffness = settings.contact.friction = 0.3f;
      if (exact) settings.sagCompensation = 0.5f;
      if (i % 3 == 0) settings.sleep.speed = 10;
      HairDef def = {.name = "a name that is too long to be within a string " + std::to_string(i),
                     .settings = settings,
                     .levelOfDetail = exact,
                     .followHairs = follows};
      if (i % 2 == 0) def.skeleton = skeleton_;
      if (i % 5 < 2) def.collidingHair = CollidingHair::kGuidesAndFollows;
      const Result<HairId> hair = scene.addHair(asset, def);
      EXPECT_TRUE(hair) << hair.error().message;
      hairs_.push_back(*hair);
      HairObject& object = scene.hair(*hair);
      if (exact) object.simulatedShare = 0.5f;
      object.tracksMotion = i % 3 < 2;
      object.interpolates = i % 7 == 0;
      object.drawnShare = 0.75f;
      object.material.fiberRadius = 0.001f;
    }
  }

  /// Sets bones and colliders, as an application does in each frame.
  void setInputs() {
    const auto t = 0.01f * static_cast<float>(++frame_ % 8);
    const AffineTransform bones[2] = {rigidTransform({0, 0, 0, 1}, {0, t, 0}),
                                      rigidTransform({0, 0, 0, 1}, {t, 0, 0})};
    scene_.skeleton(skeleton_).setBones(bones);
    const CapsuleCollider capsule = {.head = {-0.1f, 0.03f + t, -0.1f},
                                     .headRadius = 0.02f,
                                     .tail = {0.4f, 0.03f, 0.1f},
                                     .tailRadius = 0.025f};
    for (size_t i = 0; i < hairs_.size(); ++i) {
      HairObject& object = scene_.hair(hairs_[i]);
      if (i % 2 == 1) object.setBones({bones, 1});
      object.setColliders({&capsule, 1});
    }
  }
  View view(uint32_t size = 64) const {
    return cameraView(
        {.eye = {0.1f, 0.04f, 0.6f}, .target = {0.05f, 0.04f, 0}, .fov = 0.8f, .width = size});
  }
  std::array<Light, 2> lights() const {
    return {Light{.shadow = HairShadow::kDeep, .shadowSize = 32},
            Light{.direction = {1, 0, 0}, .shadow = HairShadow::kDepth, .shadowSize = 32}};
  }
  /// A frame with a picture by each method of `methods`, and one of depth and motion.
  Frame makeFrame(std::span<const Transparency> methods, uint32_t size = 64) {
    Result<Frame> frame = scene_.simulate(1.0f / 60);
    EXPECT_TRUE(frame) << frame.error().message;
    EXPECT_TRUE(frame->interpolate(0.5f));
    for (const Transparency method : methods)
      EXPECT_TRUE(frame->draw(view(size), lights(), {.method = method}));
    EXPECT_TRUE(frame->drawDepth(view(size), {.color = HairDepthColor::kMotion}));
    return *std::move(frame);
  }

 private:
  Scene& scene_;
  SkeletonId skeleton_ = SkeletonId::kInvalid;
  std::vector<HairId> hairs_;
  int frame_ = 0;
};

/// Calls of operator new on this thread in the frames behind those that warm up.
template <class Run>
uint64_t allocationsOf(const Run& runFrame) {
  uint64_t sum = 0;
  for (int frame = 0; frame < SteadyScene::kWarmUp + SteadyScene::kFrames; ++frame) {
    const uint64_t before = g_newCount;
    runFrame();
    if (frame >= SteadyScene::kWarmUp) sum += g_newCount - before;
  }
  return sum;
}

}  // namespace pelage::test
