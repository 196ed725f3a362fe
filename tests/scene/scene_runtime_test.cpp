// Hair, colliders and skeletons that come and go: what is in the lists and in memory, without a
// GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/skeleton.h"
#include "scene/scene_lists.h"
#include "support/not_numbers.h"
#include "support/views.h"

namespace pelage::test {
namespace {

CollisionMesh boxMesh(float half = 0.1f) {
  CollisionMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(
        {(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
    mesh.normals.push_back({0, 1, 0});
  }
  mesh.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                  2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  return mesh;
}

AffineTransform shifted(float x) { return rigidTransform({0, 0, 0, 1}, {x, 0, 0}); }

class SceneRuntimeTest : public SceneListTest {
 protected:
  ColliderId addCollider(const SdfColliderDef& def = {}) {
    return SceneListTest::addCollider(boxMesh(), def);
  }
  SkeletonId addSkeleton(uint32_t bones) {
    return valueOf(scene_.addSkeleton({.name = "walker", .boneCount = bones}));
  }
  size_t uploadsTo(BufferId buffer) const { return test::uploadsTo(list_, buffer); }
  template <class T>
  std::vector<T> uploaded(BufferId buffer) const {
    return test::uploaded<T>(list_, buffer);
  }
  size_t contactSdfCount(HairId hair) const {
    return uploaded<Sdf>(scene_.hair(hair).buffers().sdfs).size();
  }
};

// ---- sets of colliders

TEST_F(SceneRuntimeTest, HairMeetsTheCollidersOfItsSetAlone) {
  const HairId all = addHair(), one = addHair(), none = addHair();
  const ColliderId a = addCollider(), b = addCollider();
  scene_.hair(one).setMeshColliders({&b, 1});
  scene_.hair(none).setMeshColliders({});
  simulate();
  EXPECT_EQ(contactSdfCount(all), 2u);
  const auto sdfs = uploaded<Sdf>(scene_.hair(one).buffers().sdfs);
  ASSERT_EQ(sdfs.size(), 1u);
  EXPECT_GT(sdfs[0].nodes.w, 0u) << "the second field of the shared buffer";
  EXPECT_EQ(scene_.hair(none).buffers().sdfs, BufferId::kInvalid);
  // A set holds in any order and with repetitions.
  const ColliderId both[] = {b, a, b};
  scene_.hair(one).setMeshColliders(both);
  simulate();
  EXPECT_EQ(contactSdfCount(one), 2u);
  scene_.hair(none).useAllMeshColliders();
  simulate();
  EXPECT_EQ(contactSdfCount(none), 2u);
  EXPECT_EQ(contactSdfCount(one), 0u) << "nothing new to upload";
}

TEST_F(SceneRuntimeTest, AColliderThatOnlyOtherHairReachesIsNotBuilt) {  // K34
  const HairId hair = addHair();
  const ColliderId met = addCollider();
  addCollider();
  scene_.hair(hair).setMeshColliders({&met, 1});
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 1u);
  EXPECT_EQ(contactSdfCount(hair), 1u);
  scene_.hair(hair).useAllMeshColliders();
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 1u) << "now it is";
}

TEST_F(SceneRuntimeTest, IdsOfRemovedCollidersAreIgnoredAndNameNoLaterOnes) {
  const HairId hair = addHair();
  const ColliderId first = addCollider();
  scene_.hair(hair).setMeshColliders({&first, 1});
  simulate();
  EXPECT_EQ(contactSdfCount(hair), 1u);
  EXPECT_TRUE(scene_.removeCollider(first));
  simulate();
  const ColliderId second = addCollider();
  EXPECT_NE(second, first);
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u) << "the hair has not asked for it";
  scene_.hair(hair).setMeshColliders({&second, 1});
  simulate();
  EXPECT_EQ(contactSdfCount(hair), 1u);
}

TEST_F(SceneRuntimeTest, AFrameThatLacksAnEnginesVerticesLosesNothing) {
  const HairId hair = addHair();
  addCollider();
  const BufferId vertices =
      scene_.resources().add({.name = "engine", .size = 8 * 12, .stride = 12});
  const ColliderId engine = addCollider({.name = "engine", .vertices = vertices});
  scene_.resources().remove(vertices);
  expectError(scene_.simulate(kFrameSeconds, list_),
              "collider 'engine': its vertex buffer does not exist");
  scene_.collider(engine).enabled = false;
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 1u) << "the other one is yet to be built";
  EXPECT_EQ(uploadsTo(scene_.hair(hair).buffers().boneTransforms), 1u);
}

// ---- follow hairs

TEST_F(SceneRuntimeTest, FollowHairsWithoutAPlaceAreRefused) {
  for (float Float4::*const member : {&Float4::x, &Float4::y, &Float4::z, &Float4::w}) {
    for (const float value :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
      FollowHair follow;
      follow.offset.*member = value;
      expectError(scene_.addHair(makeAsset(), {.followHairs = {&follow, 1}}),
                  "offset of follow hair 0");
    }
  }
}

// In frames in which hair may sleep their dispatch is indirect, and no list can tell.
TEST_F(SceneRuntimeTest, MoreFollowHairsThanADispatchTakesAreStoredByNoObject) {
  const std::vector<FollowHair> follows(2'097'121);
  const HairAsset asset = makeAsset(1, 2);
  const auto expectRefused = [&](const HairDef& def) {
    expectError(scene_.addHair(asset, def), "2097121 follow hairs");
  };
  expectRefused({.followHairs = follows, .storeFollowHairs = true});
  expectRefused({.followHairs = follows, .collidingHair = CollidingHair::kGuidesAndFollows});
  EXPECT_TRUE(scene_.addHair(asset, {.followHairs = follows})) << "not stored";
}

TEST_F(SceneRuntimeTest, FollowHairsCollideWhereTheyShallAndSomethingIsInReach) {
  FollowHair follow;
  follow.offset = {0.02f, 0, 0, 1};
  const auto addBoth = [&](CollidingHair colliding) {
    return addHair({.followHairs = {&follow, 1}, .collidingHair = colliding});
  };
  const HairId guides = addBoth(CollidingHair::kGuides);
  const ColliderId box = addCollider();
  simulate();
  EXPECT_EQ(count("collide_follow_hairs") + count("update_follow_hairs"), 0u);
  EXPECT_EQ(count("find_follow_contacts"), 0u);
  EXPECT_EQ(scene_.hair(guides).buffers().followBefore, BufferId::kInvalid);
  const HairId both = addBoth(CollidingHair::kGuidesAndFollows);
  scene_.collider(box).enabled = false;
  simulate();
  EXPECT_EQ(count("update_follow_hairs"), 1u) << "they are stored";
  EXPECT_EQ(count("collide_follow_hairs"), 0u) << "nothing is in reach";
  EXPECT_EQ(count("find_follow_contacts"), 0u);
  EXPECT_EQ(scene_.hair(both).buffers().followBefore, BufferId::kInvalid);
  EXPECT_EQ(scene_.hair(both).buffers().followContactWords, BufferId::kInvalid);
  scene_.collider(box).enabled = true;
  simulate();
  const size_t passes = list_.passes.size();
  ASSERT_GE(passes, 5u);
  EXPECT_STREQ(list_.passes[passes - 5].name, "update_follow_hairs");
  for (const size_t pass : {passes - 4, passes - 2}) {
    // A second time for the strands that the first one has marked.
    EXPECT_STREQ(list_.passes[pass].name, "find_follow_contacts");
    EXPECT_STREQ(list_.passes[pass + 1].name, "collide_follow_hairs");
    const BufferId words = scene_.hair(both).buffers().followContactWords;
    for (const size_t i : {pass, pass + 1})
      EXPECT_EQ(list_.passes[i].indirect == words, pass == passes - 2) << i;
  }
  const BufferDesc* before = scene_.resources().find(scene_.hair(both).buffers().followBefore);
  ASSERT_NE(before, nullptr);
  EXPECT_EQ(before->size, 2 * 8 * sizeof(Float4));
  const CapsuleCollider capsule = {.headRadius = 0.05f, .tailRadius = 0.05f};
  scene_.collider(box).enabled = false;
  scene_.hair(both).setColliders({&capsule, 1});
  simulate();
  EXPECT_EQ(count("collide_follow_hairs"), 2u) << "capsules, too";
  const HairBuffers had = scene_.hair(both).buffers();
  EXPECT_TRUE(scene_.removeHair(both));
  EXPECT_EQ(scene_.resources().find(had.followBefore), nullptr);
  EXPECT_EQ(scene_.resources().find(had.followContactWords), nullptr);
}

TEST_F(SceneRuntimeTest, WhereFollowHairsWereIsKnownFromFrameToFrameAlone) {
  FollowHair follow;
  follow.offset = {0.02f, 0, 0, 1};
  HairObject& hair = scene_.hair(
      addHair({.followHairs = {&follow, 1}, .collidingHair = CollidingHair::kGuidesAndFollows}));
  SdfCollider& box = scene_.collider(addCollider());
  const auto history = [&] {
    simulate();
    const Pass* pass = findPass(list_, "collide_follow_hairs");
    if (pass == nullptr) return -1;
    return static_cast<int>(
        constantsOf<FollowCollisionConstants>(list_, *pass, "FollowCollisionConstants")
            .followHistory);
  };
  EXPECT_EQ(history(), 0) << "there is no frame before";
  EXPECT_EQ(history(), 1);
  box.enabled = false;
  EXPECT_EQ(history(), -1);
  box.enabled = true;
  EXPECT_EQ(history(), 0) << "after a pause it is not known";
  EXPECT_EQ(history(), 1);
  hair.simulated = false;
  EXPECT_EQ(history(), -1);
  hair.simulated = true;
  EXPECT_EQ(history(), 0) << "hair that was not simulated has not collided";
  EXPECT_EQ(history(), 1);
  hair.reset();
  EXPECT_EQ(history(), 0);
}

TEST_F(SceneRuntimeTest, ACollidersReachIsThatOfFollowHairsWhereTheyCollide) {
  FollowHair follow;
  follow.offset = {0.5f, 0, 0, 1};
  const ColliderId box = addCollider();
  const AffineTransform bone = shifted(0.6f);
  scene_.collider(box).setBones({&bone, 1});
  addHair({.followHairs = {&follow, 1}});
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 0u);
  addHair({.followHairs = {&follow, 1}, .collidingHair = CollidingHair::kGuidesAndFollows});
  simulate();
  EXPECT_EQ(count("scatter_triangles"), 1u);
  EXPECT_EQ(count("collide_follow_hairs"), 2u);
}

// ---- skeletons

TEST_F(SceneRuntimeTest, WhatFollowsASkeletonSharesOneUploadAMethod) {
  const SkeletonId id = addSkeleton(3);
  const HairId a = addHair({.skeleton = id}), b = addHair({.boneCount = 3, .skeleton = id});
  const HairId dual = addHair({.skinning = SkinningMethod::kDualQuaternions, .skeleton = id});
  const HairId own = addHair();
  const ColliderId collider = addCollider({.skeleton = id});
  const auto bones = [&](HairId hair) { return scene_.hair(hair).buffers().boneTransforms; };
  EXPECT_EQ(scene_.hair(a).boneCount(), 3u);
  EXPECT_EQ(bones(a), bones(b));
  EXPECT_EQ(bones(a), scene_.collider(collider).buffers().bones);
  EXPECT_NE(bones(a), bones(dual));
  EXPECT_NE(bones(a), bones(own));
  simulate();
  EXPECT_EQ(uploadsTo(bones(a)), 1u);
  EXPECT_EQ(uploadsTo(bones(dual)), 1u);
  EXPECT_EQ(count("skin_roots"), 4u);
  EXPECT_EQ(count("skin_vertices"), 1u);
  for (int frame = 0; frame < 3; ++frame) simulate();
  EXPECT_EQ(uploadsTo(bones(a)) + uploadsTo(bones(dual)) + count("skin_roots"), 0u) << "at rest";
  const std::vector<AffineTransform> pose(3, shifted(0.02f));
  scene_.skeleton(id).setBones(pose);
  simulate();
  EXPECT_EQ(uploadsTo(bones(a)), 1u);
  EXPECT_EQ(uploaded<Float4>(bones(a)).size(), 9u);
  EXPECT_EQ(uploaded<Float4>(bones(a))[0].w, 0.02f);
  EXPECT_EQ(uploaded<Float4>(bones(dual)).size(), 6u);
  EXPECT_EQ(count("skin_roots"), 3u) << "not the one with bones of its own";
  EXPECT_EQ(count("scatter_triangles"), 1u) << "the collider has moved";
  scene_.skeleton(id).setBones(pose);
  for (int frame = 0; frame < 3; ++frame) simulate();
  EXPECT_EQ(uploadsTo(bones(a)) + count("skin_roots"), 0u) << "the same bones again";
}

TEST_F(SceneRuntimeTest, ASkeletonThatNothingReadsIsNotUploaded) {
  const SkeletonId id = addSkeleton(1);
  const ColliderId collider = addCollider({.skeleton = id});
  addHair();
  simulate();
  const BufferId bones = scene_.collider(collider).buffers().bones;
  EXPECT_EQ(uploadsTo(bones), 1u);
  AffineTransform bone = shifted(5);
  scene_.skeleton(id).setBones({&bone, 1});
  simulate();
  EXPECT_EQ(uploadsTo(bones), 0u) << "no hair reaches it there";
  bone = shifted(0.01f);
  scene_.skeleton(id).setBones({&bone, 1});
  simulate();
  EXPECT_EQ(uploadsTo(bones), 1u);
  EXPECT_EQ(count("scatter_triangles"), 1u);
}

// As a hair object and a collider with bones of their own have it.
TEST_F(SceneRuntimeTest, SkeletonsThatWalkTakeHairAndFieldsAlong) {  // K31
  const SkeletonId id = addSkeleton(1);
  const HairId hair = addHair({.skeleton = id});
  const ColliderId collider = addCollider({.skeleton = id});
  for (int frame = 0; frame <= 40; ++frame) {
    const float x = 0.25f * static_cast<float>(frame);
    const AffineTransform bone = shifted(x);
    scene_.skeleton(id).setBones({&bone, 1});
    simulate();
    const auto sdfs = uploaded<Sdf>(scene_.hair(hair).buffers().sdfs);
    ASSERT_EQ(sdfs.size(), 1u) << "frame " << frame;
    EXPECT_LT(std::abs(sdfs[0].origin.x), 2.5f) << "relative to an origin that goes with it";
    const SdfGrid& grid = scene_.collider(collider).grid();
    EXPECT_LT(grid.origin.x, x - 0.1f);
    EXPECT_GT(grid.origin.x + grid.cellSize * static_cast<float>(grid.nodes[0] - 1), x + 0.1f);
    // The bones that are uploaded are relative to the same origin as the field and the roots.
    const auto bones = uploaded<Float4>(scene_.hair(hair).buffers().boneTransforms);
    ASSERT_EQ(bones.size(), 3u);
    const float origin = x - bones[0].w;
    EXPECT_EQ(origin, std::round(origin)) << "whole metres";
    EXPECT_NEAR(grid.origin.x - origin, sdfs[0].origin.x, 1e-4);
  }
}

TEST_F(SceneRuntimeTest, SkeletonsWakeHairAndBrokenBonesStayWhereTheyWere) {
  const SkeletonId id = addSkeleton(2);
  addHair({.skeleton = id});
  std::vector<AffineTransform> pose = {shifted(0.1f), shifted(0.2f)};
  scene_.skeleton(id).setBones(pose);
  pose = {shifted(kNan), shifted(0.3f)};
  scene_.skeleton(id).setBones(pose);
  EXPECT_EQ(scene_.skeleton(id).bones()[0], shifted(0.1f));
  EXPECT_EQ(scene_.skeleton(id).bones()[1], shifted(0.3f));
}

TEST_F(SceneRuntimeTest, WhatIsWrongWithASkeletonIsNamed) {
  expectError(scene_.addSkeleton({.name = "nobody", .boneCount = 0}), "'nobody'");
  const SkeletonId id = addSkeleton(3);
  const uint32_t buffers = scene_.resources().count();
  expectError(scene_.addHair(makeAsset(), {.boneCount = 2, .skeleton = id}),
              "boneCount is 2, but skeleton 'walker' has 3 bones");
  std::vector<BoneInfluences> influences(5);
  influences[4].bones[1] = 3;
  expectError(scene_.addHair(makeAsset(), {.influences = influences, .skeleton = id}),
              "guide 4 refers to bone 3");
  expectError(scene_.addCollider(boxMesh(), {.boneCount = 4, .skeleton = id}), "boneCount is 4");
  const BufferId vertices =
      scene_.resources().add({.name = "engine", .size = 8 * 32, .stride = 32});
  expectError(scene_.addCollider(boxMesh(), {.skeleton = id, .vertices = vertices}),
              "vertex buffer");
  scene_.resources().remove(vertices);
  SdfData data;
  expectError(scene_.addCollider(data, {.skeleton = id}), "never moves");
  EXPECT_EQ(scene_.resources().count(), buffers) << "what is refused leaves nothing";
  // In use it is kept.
  const HairId hair = addHair({.skeleton = id});
  const ColliderId collider = addCollider({.skeleton = id});
  expectError(scene_.removeSkeleton(id), "hair 'hair' follows it");
  EXPECT_TRUE(scene_.removeHair(hair));
  expectError(scene_.removeSkeleton(id), "collider 'collider' follows it");
  EXPECT_TRUE(scene_.removeCollider(collider));
  EXPECT_TRUE(scene_.removeSkeleton(id));
  expectError(scene_.addHair(makeAsset(), {.skeleton = id}),
              "the id of its skeleton belongs to a removed object");
  EXPECT_NE(addSkeleton(3), id);
  EXPECT_EQ(scene_.resources().count(), buffers);
}

// ---- lifetimes

constexpr Transparency kAllMethods[] = {Transparency::kAlphaTest, Transparency::kStochastic,
                                        Transparency::kWindowed,  Transparency::kHybrid4,
                                        Transparency::kHybrid8,   Transparency::kHybrid16,
                                        Transparency::kShortCut,  Transparency::kTiles};

class SceneLifetimeTest : public SceneRuntimeTest {
 protected:
  // A frame in which everything that makes buffers is used.
  void fill(Solver solver) {
    const SkeletonId skeleton = addSkeleton(2);
    const FollowHair follow = {.offset = {0.01f, 0, 0, 1}};
    HairDef def = {.skeleton = skeleton,
                   .levelOfDetail = true,
                   .followHairs = {&follow, 1},
                   .collidingHair = CollidingHair::kGuidesAndFollows};
    def.settings.solver = solver;
    def.settings.contact = {.stiffness = 0.5f, .friction = 0.5f};
    def.settings.globalStiffness = 0.1f;
    def.settings.curves.stiffness[2] = 2;
    const HairId first = addHair(def);
    def.skinning = SkinningMethod::kDualQuaternions;
    def.skeleton = SkeletonId::kInvalid;
    const HairId second = addHair(def);
    const ColliderId own = addCollider(), followed = addCollider({.skeleton = skeleton});
    const CapsuleCollider capsules[2] = {{.headRadius = 0.1f, .tailRadius = 0.1f}, {}};
    scene_.hair(first).setColliders(capsules);
    for (int frame = 0; frame < 3; ++frame) {
      simulate();
      // In the middle of its life it changes its solver, too.
      if (frame == 1) {
        HairObject& hair = scene_.hair(second);
        hair.settings.solver = solver == Solver::kExact ? Solver::kClassic : Solver::kExact;
        const AffineTransform bone = shifted(0.3f);
        scene_.collider(own).setBones({&bone, 1});
      }
    }
    drawAll(own);
    hairs_ = {first, second};
    colliders_ = {own, followed};
    skeleton_ = skeleton;
  }
  void drawAll(ColliderId collider) {
    View view = cameraView({.eye = {0, 0, 1}, .fov = 1, .nearPlane = 0.1f, .farPlane = 10});
    view.height = 48;
    const Light light = {.shadow = HairShadow::kDeep};
    std::vector<PassList> lists;
    for (const Transparency method : kAllMethods) {
      expectOk(scene_.draw(view, {&light, 1}, {.method = method}, lists));
    }
    PassList list;
    expectOk(scene_.drawCollider(collider, view, light, {}, list));
  }
  void empty() {
    for (const HairId id : hairs_) EXPECT_TRUE(scene_.removeHair(id));
    for (const ColliderId id : colliders_) EXPECT_TRUE(scene_.removeCollider(id));
    expectOk(scene_.removeSkeleton(skeleton_));
  }

  std::vector<HairId> hairs_;
  std::vector<ColliderId> colliders_;
  SkeletonId skeleton_ = SkeletonId::kInvalid;
};

TEST_F(SceneLifetimeTest, WhatIsRemovedLeavesNothingBehind) {
  std::set<HairId> hairs;
  std::set<uint32_t> slots;
  uint64_t bytes = 0;
  uint32_t count = 0;
  for (int round = 0; round < 12; ++round) {
    fill(round % 2 == 0 ? Solver::kExact : Solver::kClassic);
    if (round < 2) {
      bytes = std::max(bytes, scene_.resources().totalBytes());
      count = std::max(count, scene_.resources().count());
    }
    EXPECT_LE(scene_.resources().totalBytes(), bytes) << "round " << round;
    EXPECT_LE(scene_.resources().count(), count);
    for (const HairId id : hairs_) {
      EXPECT_TRUE(hairs.insert(id).second) << "an id is given once";
      slots.insert(static_cast<uint32_t>(id) & 0xffffu);
    }
    empty();
    EXPECT_EQ(scene_.resources().count(), 0u) << "round " << round;
    EXPECT_EQ(scene_.resources().totalBytes(), 0u);
    EXPECT_EQ(scene_.hairCount(), 0u);
  }
  EXPECT_EQ(slots.size(), 2u) << "places are used again";
  EXPECT_LE(scene_.resources().end(), count) << "those of buffers, too";
}

TEST_F(SceneLifetimeTest, TrimGivesBackWhatDrawsHaveMadeAndTheNextDrawMakesItAgain) {
  fill(Solver::kExact);
  const auto namesOf = [&] {
    std::set<std::string> names;
    for (uint32_t i = 0; i < scene_.resources().end(); ++i) {
      const BufferDesc* desc = scene_.resources().find(scene_.resources().at(i));
      if (desc != nullptr) names.insert(desc->name);
    }
    return names;
  };
  const std::set<std::string> before = namesOf();
  scene_.trim();
  for (const std::string& name : namesOf()) {
    EXPECT_FALSE(name.starts_with("transparency/") || name.starts_with("shadows/")) << name;
    EXPECT_EQ(name.find("/iso"), std::string::npos) << name;
  }
  EXPECT_EQ(scene_.shadowWords(), BufferId::kInvalid);
  EXPECT_EQ(scene_.transparencyCounters(), BufferId::kInvalid);
  simulate();
  drawAll(colliders_[0]);
  EXPECT_EQ(namesOf(), before);
  // The last hair object takes them along, the one before it does not.
  EXPECT_TRUE(scene_.removeHair(hairs_[0]));
  EXPECT_NE(scene_.shadowWords(), BufferId::kInvalid);
  EXPECT_TRUE(scene_.removeHair(hairs_[1]));
  EXPECT_EQ(scene_.shadowWords(), BufferId::kInvalid);
}

TEST_F(SceneLifetimeTest, RefusesIdsThatNameNothing) {
  fill(Solver::kExact);
  EXPECT_EQ(HairId{}, HairId::kInvalid);
  EXPECT_EQ(ColliderId{}, ColliderId::kInvalid);
  EXPECT_EQ(SkeletonId{}, SkeletonId::kInvalid);
  EXPECT_EQ(BufferId{}, BufferId::kInvalid);
  EXPECT_EQ(scene_.resources().find(BufferId{}), nullptr);
  EXPECT_FALSE(scene_.isValid(HairId{}));

  EXPECT_TRUE(scene_.isValid(hairs_[0]));
  EXPECT_TRUE(scene_.isValid(colliders_[0]));
  expectError(scene_.removeHair(HairId{}), "removeHair(): the id is zero");
  expectError(scene_.removeCollider(ColliderId{}), "removeCollider(): the id is zero");
  expectError(scene_.removeSkeleton(SkeletonId{}), "removeSkeleton(): the id is zero");

  // The other scene gave out ids before, and in the same slots.
  Scene other;
  const Result<HairId> foreign = required(other.addHair(makeAsset(), {.name = "foreign"}));
  EXPECT_FALSE(scene_.isValid(*foreign));
  EXPECT_FALSE(other.isValid(hairs_[0]));
  expectError(scene_.removeHair(*foreign), "belongs to another scene");
  expectError(other.removeHair(hairs_[0]), "belongs to another scene");
  EXPECT_EQ(other.hairCount(), 1u);
  EXPECT_EQ(scene_.hairCount(), hairs_.size());

  // A scene that moves takes its ids along.
  Scene moved = std::move(other);
  EXPECT_TRUE(moved.isValid(*foreign));
  const Result<HairId> later = required(other.addHair(makeAsset(), {.name = "later"}));
  EXPECT_FALSE(moved.isValid(*later));

  const HairId gone = hairs_[1];
  ASSERT_TRUE(scene_.removeHair(gone));
  hairs_.pop_back();
  EXPECT_FALSE(scene_.isValid(gone));
  expectError(scene_.removeHair(gone), "belongs to a removed object");
}

TEST_F(SceneLifetimeTest, EndsWhereAnIdNamesNothingAndTheHandlerReturns) {
  EXPECT_DEATH(
      {
        setAssertHandler([](const char*, const char* message, const char*, int) {
          std::fprintf(stderr, "handled: %s\n", message);
        });
        scene_.hair(HairId{});
      },
      "handled: hair\\(\\): the id is zero");
}

}  // namespace
}  // namespace pelage::test
