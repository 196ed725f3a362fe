// A scene without a GPU: frames that do not run, and objects that come and go in between.
#include <gtest/gtest.h>

#include "pelage/gpu_structs.h"
#include "pelage/skeleton.h"
#include "scene/scene_lists.h"
#include "support/delivery_scene.h"

namespace pelage::test {
namespace {

class SceneDeliveryTest : public SceneListTest {
 protected:
  ColliderId addCollider(const SdfColliderDef& def = {.cellSize = 0.012f, .boneCount = 2}) {
    return SceneListTest::addCollider(twoBoxes(), def);
  }
  bool uploads(BufferId buffer) const { return uploadsTo(list_, buffer) > 0; }
  /// Flags of the first solver pass of the list.
  uint32_t flags(const char* kernel = "simulate_exact") const {
    const Pass* pass = findPass(list_, kernel);
    return pass != nullptr ? constantsOf<ExactConstants>(list_, *pass, "ExactConstants").flags : 0;
  }
  /// With or without contacts.
  bool resets() const { return ((flags() | flags("eliminate_strands")) & 1u) != 0; }

  PassList other_;
};

TEST_F(SceneDeliveryTest, WhatALostFrameSentIsSentAgainAndNothingTwice) {
  HairObject& hair = scene_.hair(addHair());
  const AffineTransform bone = rigidTransform({0, 0, 0, 1}, {0.1f, 0, 0});
  hair.setBones({&bone, 1});
  for (int lost = 0; lost < 3; ++lost) {
    write(list_);
    EXPECT_TRUE(uploads(hair.buffers().boneTransforms)) << lost;
    EXPECT_TRUE(resets()) << lost;
  }
  run();
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  EXPECT_TRUE(resets());
  EXPECT_EQ(scene_.time(), static_cast<double>(kFrameSeconds));
  run();
  EXPECT_FALSE(uploads(hair.buffers().boneTransforms));
  EXPECT_FALSE(resets());
}

TEST_F(SceneDeliveryTest, TheListOfAnEarlierFrameIsRefused) {
  addHair();
  write(other_);
  write(list_);
  expectError(checkRun(other_), "was abandoned");
  EXPECT_TRUE(checkRun(list_));
  setDelivered(list_.run);
  // Not even with new barriers.
  scene_.finish(other_);
  EXPECT_FALSE(checkRun(other_));
}

TEST_F(SceneDeliveryTest, AFrameOnTopOfOneThatDoesNotRunDoesNotEither) {
  addHair();
  run();
  write(list_);
  setRecorded(list_.run);
  ASSERT_TRUE(scene_.simulate(kFrameSeconds, other_)) << "in the same command buffer";
  abandon(list_.run);
  scene_.finish(other_);
  EXPECT_FALSE(checkRun(other_));
  run();
  EXPECT_EQ(scene_.time(), 2 * static_cast<double>(kFrameSeconds));
}

TEST_F(SceneDeliveryTest, BuffersThatALostFrameReplacedAreThereAgain) {
  HairObject& hair = scene_.hair(addHair());
  run();
  const HairBuffers before = hair.buffers();
  const uint32_t buffers = scene_.resources().count();
  hair.settings.solver = Solver::kClassic;
  write(list_);
  const BufferId made = hair.buffers().state;
  EXPECT_NE(made, before.state);
  EXPECT_NE(scene_.resources().find(before.state), nullptr) << "it may be needed again";
  hair.settings.solver = Solver::kExact;
  run();
  EXPECT_EQ(hair.buffers().state, before.state);
  EXPECT_EQ(scene_.resources().find(made), nullptr);
  EXPECT_EQ(scene_.resources().count(), buffers);
  EXPECT_FALSE(resets()) << "as if it had never been classic";
}

TEST_F(SceneDeliveryTest, SettingsOfALostFrameAreNoChange) {
  HairObject& hair = scene_.hair(addHair());
  for (int frame = 0; frame < 3; ++frame) run();
  const auto wakes = [&] {
    return findPass(list_, "select_awake_tiles") == nullptr ||
           (flags("select_awake_tiles") & 16u) != 0;
  };
  EXPECT_FALSE(wakes());
  hair.settings.damping = 0.9f;
  write(list_);
  EXPECT_TRUE(wakes());
  hair.settings.damping = SimulationSettings().damping;
  run();
  EXPECT_FALSE(wakes());
}

TEST_F(SceneDeliveryTest, ThingsMayComeAndGoWhileAFrameIsOpen) {
  for (const bool runs : {false, true}) {
    SCOPED_TRACE(runs);
    Scene scene;
    const auto step = [&](PassList& list) {
      expectOk(scene.simulate(kFrameSeconds, list));
      scene.finish(list);
    };
    const auto skeleton = scene.addSkeleton({.name = "walker", .boneCount = 2});
    const auto gone = scene.addHair(makeAsset(), {.name = "gone", .skeleton = *skeleton});
    const auto kept = scene.addHair(makeAsset(), {.name = "kept"});
    const auto mesh = scene.addCollider(twoBoxes(), {.cellSize = 0.012f, .boneCount = 2});
    ASSERT_TRUE(gone && kept && mesh);
    step(list_);
    setDelivered(list_.run);
    // Everything that has a part in it makes buffers anew.
    for (const HairId id : {*gone, *kept}) scene.hair(id).settings.solver = Solver::kClassic;
    const AffineTransform far[2] = {rigidTransform({0, 0, 0, 1}, {0.05f, 0, 0}),
                                    rigidTransform({0, 0, 0, 1}, {-0.15f, 0.05f, 0})};
    scene.collider(*mesh).setBones(far);
    step(list_);
    EXPECT_TRUE(scene.removeHair(*gone));
    const auto late = scene.addHair(makeAsset(), {.name = "late"});
    const auto other = scene.addCollider(twoBoxes(), {.cellSize = 0.012f, .boneCount = 2});
    ASSERT_TRUE(late && other);
    ASSERT_TRUE(scene.removeSkeleton(*skeleton));
    if (runs) setDelivered(list_.run);
    for (int frame = 0; frame < 3; ++frame) {
      step(list_);
      for (const Pass& pass : list_.passes) {
        for (const PassBinding& binding : list_.bindingsOf(pass)) {
          if (binding.buffer == BufferId::kInvalid) continue;
          EXPECT_NE(scene.resources().find(binding.buffer), nullptr) << pass.name;
        }
      }
      if (frame == 0) {
        EXPECT_EQ(count("scatter_triangles"), 2u) << "both fields have new places";
      }
      setDelivered(list_.run);
    }
    for (const HairId id : {*kept, *late}) EXPECT_TRUE(scene.removeHair(id));
    for (const ColliderId id : {*mesh, *other}) EXPECT_TRUE(scene.removeCollider(id));
    EXPECT_EQ(scene.resources().count(), 0u) << "nothing is left behind";
    step(list_);
  }
}

TEST_F(SceneDeliveryTest, RemovingAColliderWhileAFrameIsOpenLeavesNothingBehind) {
  for (const bool runs : {false, true}) {
    const HairId hair = addHair();
    const ColliderId a = addCollider(), b = addCollider();
    run();
    const AffineTransform far[2] = {rigidTransform({0, 0, 0, 1}, {0.3f, 0, 0}),
                                    rigidTransform({0, 0, 0, 1}, {-0.4f, 0.05f, 0})};
    scene_.collider(a).setBones(far);
    write(list_);
    EXPECT_TRUE(scene_.removeCollider(a));
    if (runs) setDelivered(list_.run);
    run();
    EXPECT_EQ(count("scatter_triangles"), 1u);
    EXPECT_TRUE(scene_.removeCollider(b));
    EXPECT_TRUE(scene_.removeHair(hair));
    EXPECT_EQ(scene_.resources().count(), 0u);
  }
}

TEST_F(SceneDeliveryTest, AFrameThatWasDeliveredCanBeTakenBackUntilTheNextOne) {
  HairObject& hair = scene_.hair(addHair());
  run();
  const AffineTransform bone = rigidTransform({0, 0, 0, 1}, {0.1f, 0, 0});
  hair.setBones({&bone, 1});
  run();
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  scene_.abandon(list_);
  EXPECT_EQ(scene_.time(), static_cast<double>(kFrameSeconds));
  run();
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  EXPECT_FALSE(resets());
}

TEST_F(SceneDeliveryTest, AnOlderFrameThatIsAbandonedResetsEverything) {
  HairObject& hair = scene_.hair(addHair());
  addCollider();
  run();
  run();
  const PassList old = list_;
  run();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  scene_.abandon(old);
  run();
  EXPECT_TRUE(resets());
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  EXPECT_TRUE(uploads(hair.buffers().sdfs));
  EXPECT_EQ(count("scatter_triangles"), 1u);
  // A list that never ran leaves nothing to repair.
  write(other_);
  run();
  scene_.abandon(other_);
  run();
  EXPECT_FALSE(resets());
}

TEST_F(SceneDeliveryTest, AResetSendsAllAgain) {
  HairObject& hair = scene_.hair(addHair());
  SdfCollider& collider = scene_.collider(addCollider());
  for (int frame = 0; frame < 4; ++frame) run();
  EXPECT_FALSE(uploads(hair.buffers().boneTransforms));
  EXPECT_FALSE(uploads(hair.buffers().sdfs));
  hair.reset();
  run();
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  EXPECT_TRUE(uploads(hair.buffers().sdfs));
  EXPECT_EQ(count("skin_roots"), 1u);
  EXPECT_EQ(count("scatter_triangles"), 0u);
  collider.reset();
  run();
  EXPECT_EQ(count("scatter_triangles"), 1u);
  EXPECT_TRUE(uploads(collider.buffers().bones));
}

TEST_F(SceneDeliveryTest, AFrameThatIsRefusedLateChangesNothing) {
  HairObject& hair = scene_.hair(addHair());
  run();
  const HairBuffers before = hair.buffers();
  const AffineTransform bone = rigidTransform({0, 0, 0, 1}, {3, 0, 0});
  hair.setBones({&bone, 1});
  hair.settings.solver = Solver::kClassic;
  hair.settings.damping = -1;
  EXPECT_FALSE(scene_.simulate(kFrameSeconds, list_));
  EXPECT_EQ(hair.buffers().state, before.state);
  hair.settings.solver = Solver::kExact;
  hair.settings.damping = 0.1f;
  run();
  EXPECT_TRUE(uploads(hair.buffers().boneTransforms));
  EXPECT_NE(flags() & 4u, 0u) << "the origin moves";
}

}  // namespace
}  // namespace pelage::test
