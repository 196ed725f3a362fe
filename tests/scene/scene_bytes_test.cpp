// Bytes of a scene's objects and views: each figure is the memory that goes with its owner.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "pelage/scene.h"
#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/views.h"

namespace pelage::test {
namespace {

uint64_t total(const Scene& scene) { return scene.resources().totalBytes(); }

uint64_t sumOf(const DrawBytes& bytes) {
  return std::accumulate(bytes.views.begin(), bytes.views.end(), bytes.shadows);
}

/// Runs a frame as far as the scene knows.
void deliver(Scene& scene, PassList& list) {
  scene.finish(list);
  setDelivered(list.run);
}

View viewOf(uint32_t pixels) {
  return cameraView({.eye = {0, 0.04f, 0.5f},
                     .target = {0, 0.04f, 0},
                     .fov = 0.6f,
                     .width = pixels,
                     .nearPlane = 0.01f,
                     .farPlane = 100});
}

HairDef defOf(Solver solver) {
  HairDef def;
  def.settings.solver = solver;
  def.settings.contact.stiffness = solver == Solver::kExact ? 0.5f : 0;
  return def;
}

TEST(SceneBytes, OfAnObjectAreWhatItsRemovalGivesBack) {
  for (const Solver solver : {Solver::kExact, Solver::kClassic}) {
    Scene scene;
    const std::vector<FollowHair> follows = {{.guide = 1, .offset = {0.001f, 0, 0, 1}}};
    HairDef def = defOf(solver);
    const Result<HairId> plain = scene.addHair(makeAsset(20), def);
    def.followHairs = follows;
    def.collidingHair = CollidingHair::kGuidesAndFollows;
    const Result<HairId> rich = scene.addHair(makeAsset(30), def);
    ASSERT_TRUE(plain && rich);
    const CapsuleCollider capsule = {
        .head = {0, 0.03f, 0}, .headRadius = 0.02f, .tail = {0.1f, 0.03f, 0}, .tailRadius = 0.02f};
    PassList list;
    for (int frame = 0; frame < 3; ++frame) {
      scene.hair(*rich).setColliders({&capsule, 1});
      ASSERT_TRUE(scene.simulate(1.0f / 60, list));
      deliver(scene, list);
    }
    scene.trim();
    const ObjectBytes a = scene.bytesOf(*plain), b = scene.bytesOf(*rich);
    EXPECT_GT(a.own, 0u);
    EXPECT_GT(a.shared, 0u);
    EXPECT_GT(b.own, a.own);
    // The ribbon's indices are those of both: strands have as many vertices.
    const uint64_t indices = scene.resources().find(scene.hair(*plain).buffers().indices)->size;
    EXPECT_EQ(a.own + a.shared + b.own + b.shared - indices, total(scene));
    // Looking has changed nothing.
    EXPECT_EQ(scene.bytesOf(*rich).own, b.own);
    EXPECT_NE(scene.hair(*rich).buffers().positions, BufferId::kInvalid);
    ASSERT_TRUE(scene.removeHair(*rich));
    scene.trim();
    EXPECT_EQ(total(scene), a.own + a.shared);
    ASSERT_TRUE(scene.removeHair(*plain));
    EXPECT_EQ(total(scene), 0u);
  }
}

TEST(SceneBytes, TablesOfEqualObjectsAreSharedAndCountedInEach) {
  Scene scene;
  const auto asset = std::make_shared<const HairAsset>(makeAsset(20));
  const Result<HairId> first = required(scene.addHair(asset, {}));
  const ObjectBytes one = scene.bytesOf(*first);
  EXPECT_EQ(one.own + one.shared, total(scene));
  const Result<HairId> second = required(scene.addHair(asset, {}));
  EXPECT_EQ(scene.bytesOf(*second).shared, one.shared);
  EXPECT_EQ(2 * one.own + one.shared, total(scene));
}

TEST(SceneBytes, OfCollidersAreWhatTheirRemovalGivesBack) {
  Scene scene;
  ASSERT_TRUE(scene.addHair(makeAsset(20), defOf(Solver::kExact)));
  const Result<SkeletonId> skeleton = scene.addSkeleton({.name = "walker", .boneCount = 2});
  const Result<ColliderId> own =
      scene.addCollider(twoBoxes(), {.name = "own", .cellSize = 0.012f, .boneCount = 2});
  const Result<ColliderId> worn =
      scene.addCollider(twoBoxes(), {.name = "worn", .cellSize = 0.02f, .skeleton = *skeleton});
  ASSERT_TRUE(own && worn);
  PassList list;
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_TRUE(scene.simulate(1.0f / 60, list));
    deliver(scene, list);
  }
  scene.trim();
  const ObjectBytes a = scene.bytesOf(*own), b = scene.bytesOf(*worn);
  EXPECT_GT(a.own, b.own) << "of smaller cells, and with bones";
  EXPECT_EQ(a.shared + b.shared, scene.resources().find(scene.sdfKeys())->size +
                                     scene.resources().find(scene.sdfSurface())->size);
  const uint64_t before = total(scene);
  ASSERT_TRUE(scene.removeCollider(*own));
  scene.trim();
  EXPECT_EQ(before - total(scene), a.own + a.shared);
}

TEST(SceneBytes, OfViewsAreTheirPlansAndWhatTrimGivesBack) {
  Scene scene;
  ASSERT_TRUE(scene.addHair(makeAsset(20), {}));
  PassList list;
  ASSERT_TRUE(scene.simulate(1.0f / 60, list));
  deliver(scene, list);
  EXPECT_TRUE(scene.drawBytes().views.empty());
  EXPECT_EQ(scene.drawBytes().shadows, 0u);
  const uint64_t before = total(scene);
  const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
  {
    Result<Frame> frame = required(scene.simulate(0));
    for (const uint32_t pixels : {100u, 50u}) {
      ASSERT_TRUE(frame->draw(viewOf(pixels), {&light, 1}));
    }
    const DrawBytes bytes = scene.drawBytes();
    ASSERT_EQ(bytes.views.size(), 2u);
    EXPECT_EQ(bytes.views[0], planTransparency(100, 100, {})->bytes);
    EXPECT_EQ(bytes.views[1], planTransparency(50, 50, {})->bytes);
    EXPECT_GE(bytes.shadows, 64u * 64 * 9 * 4);
    EXPECT_EQ(total(scene) - before, sumOf(bytes));
  }
  scene.trim();
  EXPECT_TRUE(scene.drawBytes().views.empty());
  EXPECT_EQ(total(scene), before);
}

}  // namespace
}  // namespace pelage::test
