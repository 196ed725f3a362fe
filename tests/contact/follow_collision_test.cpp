// Follow hairs of a scene on mesh colliders and capsules, on every API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "pelage/skeleton.h"
#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "support/collision_shapes.h"
#include "support/plain_asset.h"
#include "support/scene_test.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

using reference::TriangleMesh;

constexpr uint32_t kGuides = 10, kFollows = 60, kVertices = 24;
constexpr float kBallRadius = 0.08f, kMargin = 0.001f, kWallTop = 0.06f;
constexpr uint32_t kHeld = 11;  // vertex of the first guide, within the ball's height

/// Strands that hang around a ball at the origin and just do not touch it.
HairAsset curtain() {
  HairAsset asset = strandsAt(kGuides, kVertices, [](uint32_t s, uint32_t v) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(s) / kGuides;
    return Float3{0.085f * std::cos(angle), 0.14f - 0.012f * static_cast<float>(v),
                  0.085f * std::sin(angle)};
  });
  asset.positions[kHeld].w = 0;
  expectOk(asset.process());
  return asset;
}

/// One strand that hangs beside the axis.
HairAsset plumb() {
  return strandsAt(1, kVertices, [](uint32_t, uint32_t v) {
    return Float3{0.02f, 0.14f - 0.012f * static_cast<float>(v), 0};
  });
}

/// Towards the ball, up to 3 cm.
std::vector<FollowHair> inwards() {
  std::vector<FollowHair> follows(kFollows);
  for (uint32_t f = 0; f < kFollows; ++f) {
    FollowHair& hair = follows[f];
    hair.guide = f % kGuides;
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(hair.guide) / kGuides;
    const float in = -0.03f * static_cast<float>(1 + f / kGuides) / (kFollows / kGuides);
    const float along = 0.004f * (static_cast<float>(f % 3) - 1);
    hair.offset = {in * std::cos(angle) - along * std::sin(angle), 0,
                   in * std::sin(angle) + along * std::cos(angle), 1};
  }
  return follows;
}

AffineTransform rotated(float angle) {
  return rigidTransform({0, std::sin(angle / 2), 0, std::cos(angle / 2)}, {});
}

class FollowCollision : public SceneTest {
 protected:
  // It says which vertices are held beyond the root; the exact solver holds them with springs.
  FollowCollision() { settings_.solver = Solver::kClassic; }
  HairObject& add(CollidingHair colliding, const HairAsset& asset,
                  const std::vector<FollowHair>& follows) {
    return run_.add(asset, {.settings = settings_,
                            .followHairs = follows,
                            .storeFollowHairs = true,
                            .collidingHair = colliding});
  }
  SdfCollider& add(const TriangleMesh& shape, float cell) {
    SdfCollider& collider = run_.scene.collider(run_.add(toMesh(shape), {.cellSize = cell}));
    collider.margin = kMargin;
    return collider;
  }
  /// A root beside a thin wall goes by x in one frame, so that its follow hair would be behind the
  /// wall. \param keptFrom least x of the collided follow hair below kWallTop
  template <class AddWall>
  void jumpOver(float x, float keptFrom, const AddWall& addWall) {
    const HairAsset asset = plumb();
    std::vector<FollowHair> follow(1);
    follow[0].offset = {-0.012f, 0, 0, 1};
    // So that the strand goes with its root at once; the wall's upper edge is below the roots.
    settings_.globalStiffness = 0.99f;
    settings_.globalRange = 1;
    HairObject& hair = add(CollidingHair::kGuidesAndFollows, asset, follow);
    HairObject& guideOnly = add(CollidingHair::kGuides, asset, follow);
    addWall(hair, guideOnly);
    for (const float at : {0.0f, 0.0f, x, x, x}) {
      const AffineTransform bone = rigidTransform({0, 0, 0, 1}, {at, 0, 0});
      setBone(hair, bone);
      setBone(guideOnly, bone);
      run_.step();
    }
    const std::vector<Float4> kept = follows(hair), evaluated = follows(guideOnly);
    for (size_t v = 0; v < kVertices; ++v) {
      if (evaluated[v].y > kWallTop) continue;
      EXPECT_LT(evaluated[v].x, -0.002f) << "vertex " << v << " would be on the other side";
      EXPECT_GT(kept[v].x, keptFrom) << "vertex " << v;
    }
  }
  SdfCollider& addBall() { return add(ball(), 0.008f); }
  static TriangleMesh ball() { return reference::sphere(kBallRadius, 24, 32); }
  std::vector<Float4> follows(const HairObject& hair) const {
    const std::vector<Float4> all = run_.positions(hair);
    return {all.begin() + ptrdiff_t{hair.guideCount()} * kVertices, all.end()};
  }

  SimulationSettings settings_;
};

TEST_P(FollowCollision, WhatWouldBeInsideAMeshIsOutsideByTheMarginWithItsLength) {  // K6, K29
  const HairAsset asset = curtain();
  const HairObject& guideOnly = add(CollidingHair::kGuides, asset, inwards());
  const HairObject& both = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  SdfCollider& collider = addBall();
  for (int frame = 0; frame < 6; ++frame) run_.step();
  EXPECT_EQ(guideOnly.buffers().followBefore, BufferId::kInvalid);
  const std::vector<Float4> evaluated = follows(guideOnly), pushed = follows(both);
  const reference::DistanceOracle oracle(ball());
  // Distances are kept in 1/2^20 of the band.
  const double outside = static_cast<double>(kMargin) - 1e-5;
  uint32_t free = 0, wasInside = 0, isInside = 0, held = 0, longer = 0;
  double longest = 0;
  for (size_t i = 0; i < evaluated.size(); ++i) {
    if (!(evaluated[i].w > 0)) {
      EXPECT_EQ(evaluated[i], pushed[i]) << "a held vertex";
      if (oracle.signedDistance(toVector(evaluated[i])) < 0) ++held;
      continue;
    }
    ++free;
    if (oracle.signedDistance(toVector(evaluated[i])) < outside) ++wasInside;
    if (oracle.signedDistance(toVector(pushed[i])) < outside) ++isInside;
    if (!(evaluated[i - 1].w > 0) || (i + 1 < evaluated.size() && !(evaluated[i + 1].w > 0)))
      continue;
    const double segment = distance(evaluated[i], evaluated[i - 1]);
    const double off = std::abs(distance(pushed[i], pushed[i - 1]) / segment - 1);
    keepLargest(longest, off);
    if (off > 1e-3) ++longer;
  }
  EXPECT_GT(wasInside, free / 4);
  EXPECT_GT(held, 0u) << "held vertices inside are a case, too";
  EXPECT_LE(isInside, free / 1000) << "of " << free;
  std::printf(
      "[ FIGURE ] %u of %u vertices inside, %u after; segments off by up to %.3g %%, %u by "
      "more than 0.1 %%\n",
      wasInside, free, isInside, 100 * longest, longer);
  EXPECT_LT(longest, 0.02);
  EXPECT_LT(longer, free / 100);
  // Where nothing touches, the bits are those of the placement.
  for (size_t i = 0; i < evaluated.size(); i += kVertices) {
    for (uint32_t v = 0; v < 4; ++v) EXPECT_EQ(evaluated[i + v], pushed[i + v]) << "above the ball";
  }
  const std::vector<Float4> all = run_.positions(both), alone = run_.positions(guideOnly);
  EXPECT_TRUE(std::equal(all.begin(), all.begin() + ptrdiff_t{kGuides} * kVertices, alone.begin()))
      << "guides do not know of it";
  // Tangents are those of the strand that is drawn.
  const std::vector<Float4> tangents = run_.read(both.buffers().tangents);
  for (size_t v = 1; v + 1 < kVertices; ++v) {
    const size_t i = (kGuides + kFollows - 1) * size_t{kVertices} + v;
    const Eigen::Vector3d across = (toVector(all[i + 1]) - toVector(all[i - 1])).normalized();
    EXPECT_LT((toVector(tangents[i]) - across).norm(), 1e-5) << "vertex " << v;
  }
  // They stay where friction has them, as far as they are placed where they were.
  run_.step();
  const std::vector<Float4> rested = follows(both), evaluatedLast = follows(guideOnly);
  run_.step();
  const std::vector<Float4> restedNow = follows(both), pointsNow = follows(guideOnly);
  const double sway = maxDistance(evaluatedLast, pointsNow);
  EXPECT_LT(sway, 1e-5);
  EXPECT_LT(maxDistance(rested, restedNow), 2 * sway + 1e-6);
  // Without the ball they are back at once.
  collider.enabled = false;
  run_.step();
  EXPECT_EQ(follows(both), follows(guideOnly));
}

TEST_P(FollowCollision, FrictionHoldsBackByItsShareOfTheDepthAndNoLonger) {  // K29
  const HairAsset asset = curtain();
  HairObject& rough = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  HairObject& smooth = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  setCollider(rough, sphereCollider({}, kBallRadius, 0.3f));
  setCollider(smooth, sphereCollider({}, kBallRadius, 0));
  double lag = 0;
  for (int frame = 0; frame < 24; ++frame) {
    const AffineTransform bone = rotated(0.03f * static_cast<float>(frame));
    setBone(rough, bone);
    setBone(smooth, bone);
    run_.step();
    const std::vector<Float4> a = follows(rough), b = follows(smooth);
    lag = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      keepLargest(lag, distance(a[i], b[i]));
      if (a[i].w > 0) {
        ASSERT_GT(toVector(a[i]).norm(), static_cast<double>(kBallRadius) - 1e-5)
            << "frame " << frame;
      }
    }
  }
  // They are up to 2.5 cm deep; what stuck would be 5 cm behind.
  EXPECT_GT(lag, 0.002);
  EXPECT_LT(lag, 1.2 * 0.3 * 0.03);
}

TEST_P(FollowCollision, AFastFollowHairStaysOnItsGuidesSideOfAThinPlate) {  // K30
  jumpOver(-0.012f, 0.002f, [&](HairObject&, HairObject&) {
    add(reference::box({-0.002f, -0.3f, -0.1f}, {0.002f, kWallTop, 0.1f}), 0.008f);
  });
}

TEST_P(FollowCollision, AFastFollowHairStaysOnItsGuidesSideOfAThinCapsule) {  // K30
  constexpr float kThin = 0.004f;
  jumpOver(-0.011f, kThin - 1e-5f, [&](HairObject& hair, HairObject& guideOnly) {
    const CapsuleCollider capsule = {
        .head = {0, kWallTop, 0}, .headRadius = kThin, .tail = {0, -0.3f, 0}, .tailRadius = kThin};
    for (HairObject* object : {&hair, &guideOnly}) setCollider(*object, capsule);
  });
}

TEST_P(FollowCollision, BetweenAMeshAndACapsuleTheyAreOutsideOfBoth) {
  const HairAsset asset = curtain();
  HairObject& guideOnly = add(CollidingHair::kGuides, asset, inwards());
  HairObject& both = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  addBall();
  // The hollow between the two is a ring at about y = -0.05.
  const CapsuleCollider capsule = {
      .head = {0, -0.1f, 0}, .headRadius = 0.075f, .tail = {0, -0.12f, 0}, .tailRadius = 0.075f};
  for (HairObject* object : {&guideOnly, &both}) setCollider(*object, capsule);
  for (int frame = 0; frame < 6; ++frame) run_.step();
  const reference::DistanceOracle oracle(ball());
  const auto isOutside = [&](const Float4& p) {
    const Eigen::Vector3d at = toVector(p);
    const double along = std::clamp(at.y(), -0.12, -0.1);
    const double beside = (at - Eigen::Vector3d(0, along, 0)).norm();
    return oracle.signedDistance(at) > static_cast<double>(kMargin) - 1e-5 && beside > 0.075 - 1e-5;
  };
  const std::vector<Float4> evaluated = follows(guideOnly), pushed = follows(both);
  uint32_t free = 0, wasInside = 0, isInside = 0;
  double deepest = 0;
  for (size_t i = 0; i < evaluated.size(); ++i) {
    if (!(evaluated[i].w > 0)) continue;
    ++free;
    if (!isOutside(evaluated[i])) ++wasInside;
    if (isOutside(pushed[i])) continue;
    ++isInside;
    keepLargest(deepest, static_cast<double>(kMargin) - oracle.signedDistance(toVector(pushed[i])));
  }
  std::printf("[ FIGURE ] %u of %u vertices inside of mesh or capsule, %u after, up to %.3g mm\n",
              wasInside, free, isInside, 1000 * deepest);
  EXPECT_GT(wasInside, free / 3);
  EXPECT_LE(isInside, free / 1000) << "of " << free;
}

TEST_P(FollowCollision, OnlyStrandsThatLeaveWhereTheirContactsWereFoundWalkOnceMore) {
  const HairAsset asset = curtain();
  // Deep ones are shifted along the ball by more than a millimeter; at its surface they stay.
  std::vector<FollowHair> shallow = inwards();
  for (FollowHair& hair : shallow) {
    hair.offset.x *= 0.2f;
    hair.offset.z *= 0.2f;
  }
  HairObject& deepHair = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  HairObject& shallowHair = add(CollidingHair::kGuidesAndFollows, asset, shallow);
  HairObject& farHair = add(CollidingHair::kGuidesAndFollows, asset, inwards());
  addBall();
  const CapsuleCollider far = {.head = {0, -0.16f, 0}, .headRadius = 0.01f, .tailRadius = 0.01f};
  CapsuleCollider beside = far;
  beside.tail = beside.head = {0, -0.18f, 0};
  farHair.setMeshColliders(std::vector<ColliderId>{});
  setCollider(farHair, beside);
  for (int frame = 0; frame < 2; ++frame) run_.step();
  const auto counters = [&](const HairObject& hair) {
    const std::vector<uint32_t> words = run_.read<uint32_t>(hair.buffers().followContactWords);
    return readFollowContactCounters(std::as_bytes(std::span(words)));
  };
  const FollowContactCounters deep = counters(deepHair), flat = counters(shallowHair);
  std::printf("[ FIGURE ] deep: %u records, %u strands again; shallow: %u and %u\n", deep.records,
              deep.strandsWalkedAgain, flat.records, flat.strandsWalkedAgain);
  EXPECT_GT(deep.records, kFollows * 4);
  EXPECT_GT(deep.strandsWalkedAgain, kFollows / 4);
  EXPECT_LE(deep.strandsWalkedAgain, kFollows);
  EXPECT_GT(flat.records, kFollows);
  EXPECT_LT(flat.strandsWalkedAgain, deep.strandsWalkedAgain / 2);
  EXPECT_EQ(counters(farHair).records, 0u) << "nothing is near";
  EXPECT_EQ(counters(farHair).strandsWalkedAgain, 0u);
}

/// Everything that was written after some frames with a mesh and a capsule that both move.
std::vector<uint32_t> bitsOf(Api api, std::string& device) {
  SceneRun& run = sharedSceneRun(api);
  if (run.device() == nullptr) return {};
  device = driverFamily(run.device()->info());
  const std::vector<FollowHair> hairs = inwards();
  HairObject& hair = run.add(curtain(), {.settings = {.solver = Solver::kClassic},
                                         .followHairs = hairs,
                                         .collidingHair = CollidingHair::kGuidesAndFollows});
  SdfCollider& ball = run.scene.collider(
      run.add(toMesh(reference::sphere(kBallRadius, 16, 20)), {.cellSize = 0.008f}));
  for (int frame = 0; frame < 12; ++frame) {
    const float x = 0.004f * static_cast<float>(frame);
    setBone(ball, rigidTransform({0, 0, 0, 1}, {x, 0, 0}));
    setCollider(hair, {.head = {0, -0.1f + x, 0.02f},
                       .headRadius = 0.08f,
                       .tail = {0.05f, -0.12f, 0},
                       .tailRadius = 0.05f});
    run.step();
  }
  std::vector<uint32_t> bits;
  for (const BufferId buffer :
       {hair.buffers().positions, hair.buffers().tangents, hair.buffers().followBefore}) {
    const std::vector<uint32_t> words = run.read<uint32_t>(buffer);
    bits.insert(bits.end(), words.begin(), words.end());
  }
  run.clear();
  return bits;
}

TEST(FollowCollisionBits, AreTheSameOnEveryApi) {
  std::vector<uint32_t> expected;
  std::string first;
  for (const Api api : kApis) {
    std::string device;
    const std::vector<uint32_t> bits = bitsOf(api, device);
    if (bits.empty()) continue;
    if (expected.empty()) {
      expected = bits;
      first = device;
    }
    if (device == first) {
      EXPECT_EQ(bits, expected) << apiName(api);
    }
  }
  if (expected.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

INSTANTIATE_TEST_SUITE_P(All, FollowCollision, testing::Values(kFirstApi), apiTestName);

}  // namespace
}  // namespace pelage::test
