// Scenes and their pass lists, without a GPU.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "scene/scene_lists.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

SimulationConstants stepOf(const PassList& list, const Pass& pass) {
  return constantsOf<SimulationConstants>(list, pass, "SimulationConstants");
}

class SceneTest : public SceneListTest {
 protected:
  // These tests look at the classic solver's passes; exact_scene_test has the others.
  HairObject& add(HairDef def = {}) {
    def.settings.solver = Solver::kClassic;
    id_ = addHair(asset_, def);
    return scene_.hair(id_);
  }

  /// The vertex kernel of the only object; as many instances as strands are drawn.
  const KernelVariant* drawnWith(const HairObject& hair) {
    PassList list;
    expectOk(scene_.draw({.width = 64, .height = 64}, {}, list));
    EXPECT_EQ(list.passes.at(0).instanceCount, hair.drawnStrands);
    return list.passes.at(0).kernel;
  }

  /// Whether a draw of the only object places follow hairs beside their guides.
  bool evaluatesFollows() {
    PassList list;
    expectOk(scene_.draw({.width = 64, .height = 64}, {}, list));
    return constantsOf<RenderConstants>(list, list.passes.at(0), "RenderConstants")
               .evaluatesFollows != 0;
  }

  HairAsset asset_ = makeAsset();
  HairId id_ = HairId::kInvalid;
};

TEST_F(SceneTest, StoredFollowHairsAddOnePassAndOneBuffer) {
  EXPECT_EQ(add().buffers().followHairRecords, BufferId::kInvalid);
  EXPECT_EQ(findPass(simulate(), "update_follow_hairs"), nullptr);
  EXPECT_TRUE(scene_.removeHair(id_));
  const auto follow = required(asset_.generateFollowHairs({.countPerGuide = 3}));
  const HairObject& hair = add({.followHairs = *follow, .storeFollowHairs = true});
  EXPECT_EQ(countPasses(simulate(), "update_follow_hairs"), 1u);
  EXPECT_NE(hair.buffers().followHairRecords, BufferId::kInvalid);
  EXPECT_EQ(hair.strandCount(), 20u);
  for (const BufferId buffer : {hair.buffers().positions, hair.buffers().tangents})
    EXPECT_EQ(scene_.resources().find(buffer)->size, 20u * 8 * sizeof(Float4));
  EXPECT_EQ(drawnWith(hair), &strandVertexVariant({}));
  EXPECT_FALSE(evaluatesFollows());
}

TEST_F(SceneTest, FollowHairsThatOnlyTheDrawingNeedsAreNeitherStoredNorUpdated) {
  asset_.strandThickness.assign(asset_.strandCount, 0.5f);
  const auto follow = required(asset_.generateFollowHairs({.countPerGuide = 3}));
  HairObject& hair = add({.followHairs = *follow});
  EXPECT_EQ(findPass(simulate(), "update_follow_hairs"), nullptr);
  EXPECT_EQ(hair.strandCount(), 20u);
  for (const BufferId buffer : {hair.buffers().positions, hair.buffers().tangents})
    EXPECT_EQ(scene_.resources().find(buffer)->size, 5u * 8 * sizeof(Float4));
  EXPECT_EQ(scene_.resources().find(hair.buffers().strandThickness)->size, 20u * sizeof(float));
  EXPECT_EQ(drawnWith(hair), &strandVertexVariant({.attributes = true}));
  EXPECT_TRUE(evaluatesFollows()) << "all " << hair.drawnStrands;
  hair.drawnStrands = 5;
  EXPECT_EQ(drawnWith(hair), &strandVertexVariant({.attributes = true}));
  EXPECT_FALSE(evaluatesFollows()) << "guides alone";
}

TEST_F(SceneTest, HairThatIsNotSimulatedHasNoPassOfASolverOrOfContacts) {
  for (const Solver solver : {Solver::kExact, Solver::kClassic}) {
    const bool exact = solver == Solver::kExact;
    const char* solve = exact ? "eliminate_strands" : "simulate_classic";
    const char* skin = exact ? "skin_exact_strands" : "skin_classic_strands";
    SimulationSettings settings;
    settings.solver = solver;
    settings.contact.stiffness = 0.5f;
    const auto follow = required(asset_.generateFollowHairs({.countPerGuide = 3}));
    const Result<HairId> id =
        required(scene_.addHair(asset_, {.settings = settings,
                                         .followHairs = *follow,
                                         .storeFollowHairs = true,
                                         .collidingHair = CollidingHair::kGuidesAndFollows}));
    HairObject& hair = scene_.hair(*id);
    const CapsuleCollider ball = {.headRadius = 0.3f, .tailRadius = 0.3f};
    hair.setColliders({&ball, 1});
    simulate();
    EXPECT_GT(countPasses(list_, solve), 0u);
    EXPECT_EQ(countPasses(list_, skin), 0u);
    hair.simulated = false;
    AffineTransform bone;
    const auto move = [&] {
      bone.rows[0].w += 0.01f;
      hair.setBones({&bone, 1});
    };
    const auto expectSkinned = [&](uint32_t roots, uint32_t skins) {
      EXPECT_EQ(simulate().passes.size(), roots + skins + 1);
      EXPECT_EQ(countPasses(list_, "skin_roots"), roots);
      EXPECT_EQ(countPasses(list_, skin), skins);
      EXPECT_EQ(countPasses(list_, "update_follow_hairs"), 1u);
    };
    move();
    expectSkinned(1, 1);
    expectSkinned(1, 1);
    // Nothing moves.
    expectSkinned(0, 0);
    ASSERT_TRUE(scene_.shiftOrigin({1, 0, 0}));
    bone.rows[0].w -= 1;
    expectSkinned(0, 1);
    expectSkinned(0, 0);
    move();
    expectSkinned(1, 1);
    hair.simulated = true;
    simulate();
    EXPECT_GT(countPasses(list_, solve), 0u);
    EXPECT_EQ(countPasses(list_, skin), 0u);
    EXPECT_GT(countPasses(list_, "find_contacts"), 0u);
    hair.blendTime = -1;
    EXPECT_FALSE(scene_.simulate(0.01f, list_));
    hair.blendTime = std::numeric_limits<float>::quiet_NaN();
    expectError(scene_.simulate(0.01f, list_), "blendTime");
    EXPECT_TRUE(scene_.removeHair(*id));
  }
}

TEST_F(SceneTest, WhatIsSwitchedOffHasNoStrengthInTheKernel) {
  HairObject& hair = add();
  hair.settings.wind.velocity = {};
  hair.settings.globalStiffness = 0;
  hair.settings.localStiffness = 0;
  hair.settings.vspCoefficient = 0;
  hair.settings.vspThreshold = std::numeric_limits<float>::infinity();
  const auto step = [&] {
    const Pass& pass = *findPass(simulate(), "simulate_classic");
    EXPECT_EQ(pass.kernel, &simulateClassicVariant({}));
    return stepOf(list_, pass);
  };
  const SimulationConstants off = step();
  EXPECT_EQ(off.wind.w, 0.0f) << "still air";
  EXPECT_EQ(off.globalStiffness, 0.0f);
  EXPECT_EQ(off.localIterations, 0u);
  EXPECT_EQ(off.vspCoefficient, 0.0f);
  EXPECT_EQ(off.vspThreshold, std::numeric_limits<float>::infinity());

  hair.settings.wind.velocity = {1, 0, 0};
  hair.settings.globalStiffness = 0.1f;
  hair.settings.localStiffness = 0.1f;
  const SimulationConstants on = step();
  EXPECT_GT(on.wind.w, 0.0f);
  EXPECT_GT(on.globalStiffness, 0.0f);
  EXPECT_EQ(on.localIterations, hair.settings.localIterations);
  hair.settings.airDrag = 0;
  hair.settings.globalRange = 0;
  EXPECT_EQ(step().wind.w, 0.0f) << "air that does not touch the hair";
  EXPECT_EQ(step().globalStiffness, 0.0f) << "that acts on no vertex";
}

TEST_F(SceneTest, ContactsAreFoundBeforeEveryStepWhereACapsuleIsWithinReach) {  // K34
  HairObject& hair = add();
  const CapsuleCollider far = {
      .head = {9, 0, 0}, .headRadius = 1, .tail = {9, 1, 0}, .tailRadius = 1};
  const CapsuleCollider near = {.headRadius = 0.1f, .tailRadius = 0.1f};
  hair.setColliders({&far, 1});
  simulate();
  simulate();
  EXPECT_EQ(countPasses(list_, "find_contacts"), 0u);
  EXPECT_NE(std::string_view(findPass(list_, "simulate_classic")->kernel->key).find("contacts=0"),
            std::string_view::npos);
  EXPECT_EQ(hair.buffers().contacts, BufferId::kInvalid);
  hair.setColliders({{near, far}});
  simulate(1.0f / 20);
  EXPECT_EQ(countPasses(list_, "find_contacts"), 3u);
  EXPECT_EQ(countPasses(list_, "simulate_classic"), 3u);
  std::string names;
  for (const Pass& pass : list_.passes)
    if (std::string_view(pass.name) != "skin_roots") names += pass.name[0];
  EXPECT_EQ(names, "fsfsfs");
  EXPECT_EQ(findPass(list_, "simulate_classic")->kernel,
            &simulateClassicVariant({.contacts = true}));
  // The classic solver takes the goals at a reset.
  hair.reset();
  EXPECT_EQ(countPasses(simulate(), "find_contacts"), 0u);
  EXPECT_EQ(countPasses(simulate(), "find_contacts"), 1u);
}

TEST_F(SceneTest, AStrandThicknessBufferExistsOnlyForAssetsThatHaveOne) {
  EXPECT_EQ(add().buffers().strandThickness, BufferId::kInvalid);
  asset_.strandThickness.assign(asset_.strandCount, 0.5f);
  EXPECT_NE(add().buffers().strandThickness, BufferId::kInvalid);
}

TEST_F(SceneTest, BonesAreUploadedOnlyWhenTheyChange) {
  HairObject& hair = add();
  EXPECT_EQ(simulate().uploads.size(), 1u);
  EXPECT_TRUE(simulate().uploads.empty());
  AffineTransform bone;
  hair.setBones({&bone, 1});
  EXPECT_TRUE(simulate().uploads.empty()) << "it is where it was";
  bone.rows[1].w = 0.1f;
  hair.setBones({&bone, 1});
  EXPECT_EQ(simulate().uploads.size(), 1u);
}

TEST_F(SceneTest, AFrameOfNoTimeDoesNothing) {
  HairObject& hair = add();
  // It has not moved yet: that is its bind pose, until a frame takes time.
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(countPasses(simulate(0), "skin_roots"), 1u);
    EXPECT_EQ(countPasses(list_, "simulate_classic"), 1u);
  }
  simulate(1.0f / 60);
  EXPECT_TRUE(simulate(0).passes.empty());
  hair.reset();
  EXPECT_FALSE(simulate(0).passes.empty());
}

TEST_F(SceneTest, LongFramesAreCutIntoEqualSubStepsThatCoverThePoseOnce) {
  add();
  EXPECT_EQ(countPasses(simulate(1.0f / 60), "simulate_classic"), 1u);
  EXPECT_EQ(countPasses(simulate(1.0f / 240), "simulate_classic"), 1u);
  simulate(1.0f / 20);
  ASSERT_EQ(countPasses(list_, "simulate_classic"), 3u);
  float end = 0;
  for (const Pass& pass : list_.passes) {
    if (std::string_view(pass.name) != "simulate_classic") continue;
    const SimulationConstants constants = stepOf(list_, pass);
    EXPECT_EQ(constants.rootBegin, end);
    EXPECT_NEAR(constants.timeStep, 1.0f / 60, 1e-7f);
    end = constants.rootEnd;
  }
  EXPECT_EQ(end, 1.0f);
  EXPECT_EQ(countPasses(simulate(10.0f), "simulate_classic"), Scene::kMaxSubSteps);
}

TEST_F(SceneTest, MapsTheArtistsValuesToTheStep) {  // K16
  HairObject& hair = add();
  hair.settings.damping = 0.2f;
  hair.settings.globalStiffness = 0.3f;
  simulate(1.0f / 60);
  SimulationConstants constants = stepOf(list_, *findPass(list_, "simulate_classic"));
  EXPECT_NEAR(constants.dampingKeep, 0.8f, 1e-6f);
  EXPECT_NEAR(constants.globalStiffness, 0.3f, 1e-6f);
  EXPECT_NEAR(constants.gravityStep, 1.0f / 3600, 1e-9f);
  EXPECT_EQ(constants.forceShare, 1.0f);
  simulate(1.0f / 120);
  constants = stepOf(list_, *findPass(list_, "simulate_classic"));
  EXPECT_NEAR(constants.timeStep, 1.0f / 120, 1e-8f);
  EXPECT_NEAR(constants.timeStepRatio, 0.5f, 1e-6f);
  // The values of a step of 1/60 s, and the share that loses the same velocity in the same time.
  EXPECT_NEAR(constants.dampingKeep, 0.8f, 1e-6f);
  EXPECT_NEAR(constants.globalStiffness, 0.3f, 1e-6f);
  EXPECT_NEAR(constants.gravityStep, 1.0f / 3600, 1e-9f);
  EXPECT_NEAR(1 - constants.forceShare * 2 * (1 - constants.dampingKeep), std::sqrt(0.8f), 1e-6f);
}

TEST_F(SceneTest, RefusesAnInvalidTimeStepOrSetting) {
  HairObject& hair = add({.name = "fringe"});
  for (const float dt :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_FALSE(scene_.simulate(dt, list_));
  }
  hair.settings.damping = 1.5f;
  const Result<void> done = scene_.simulate(1.0f / 60, list_);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message,
            "hair 'fringe': simulation setting 'damping' is 1.5, but must be in 0..1");
  EXPECT_TRUE(list_.passes.empty());
}

TEST_F(SceneTest, ResetLastsOneFrame) {
  HairObject& hair = add();
  simulate();
  EXPECT_EQ(stepOf(list_, *findPass(list_, "simulate_classic")).flags, 1u);
  simulate();
  EXPECT_EQ(stepOf(list_, *findPass(list_, "simulate_classic")).flags, 0u);
  hair.reset();
  simulate();
  EXPECT_EQ(stepOf(list_, *findPass(list_, "simulate_classic")).flags, 1u);
}

TEST_F(SceneTest, PassesThatDependOnEachOtherAreSeparatedByBarriers) {
  const auto follow = asset_.generateFollowHairs({.countPerGuide = 1});
  const HairObject& hair = add({.followHairs = *follow, .storeFollowHairs = true});
  simulate();
  const auto waitsFor = [&](const char* pass, BufferId buffer) {
    for (const Barrier& barrier : list_.barriersOf(*findPass(list_, pass)))
      if (barrier.buffer == buffer && writes(barrier.before) && reads(barrier.after)) return true;
    return false;
  };
  EXPECT_TRUE(waitsFor("skin_roots", hair.buffers().boneTransforms));
  EXPECT_TRUE(waitsFor("simulate_classic", hair.buffers().state));
  EXPECT_TRUE(waitsFor("update_follow_hairs", hair.buffers().positions));
}

TEST_F(SceneTest, DispatchesOnlyTheThreadsThatHaveAStrand) {  // K1
  asset_ = makeAsset(130, 4);
  add();
  simulate();
  EXPECT_EQ(findPass(list_, "simulate_classic")->groups[0], 3u);
  EXPECT_EQ(stepOf(list_, *findPass(list_, "simulate_classic")).guideCount, 130u);
}

TEST_F(SceneTest, HiddenObjectsAreNotDrawn) {
  HairObject& hair = add();
  const View view{.width = 64, .height = 64};
  PassList list;
  ASSERT_TRUE(scene_.draw(view, {}, list));
  ASSERT_EQ(list.passes.size(), 1u);
  EXPECT_EQ(list.passes[0].elementCount, 7u * 6);
  EXPECT_EQ(list.passes[0].instanceCount, 5u);
  list.clear();
  hair.drawnStrands = 2;
  ASSERT_TRUE(scene_.draw(view, {}, list));
  EXPECT_EQ(list.passes[0].instanceCount, 2u);
  list.clear();
  hair.visible = false;
  ASSERT_TRUE(scene_.draw(view, {}, list));
  EXPECT_TRUE(list.passes.empty());
}

TEST_F(SceneTest, RefusesGroomsThatDoNotFitTogether) {
  const std::vector<BoneInfluences> influences(asset_.strandCount - 1);
  EXPECT_FALSE(scene_.addHair(asset_, {.influences = influences}));
  std::vector<BoneInfluences> wrong(asset_.strandCount);
  wrong[3].bones[1] = 7;
  expectError(scene_.addHair(asset_, {.influences = wrong, .boneCount = 7}),
              "guide 3 refers to bone 7");
  const std::vector<FollowHair> follow = {{.guide = 5, .offset = {}}};
  EXPECT_FALSE(scene_.addHair(asset_, {.followHairs = follow}));
  EXPECT_FALSE(scene_.addHair(HairAsset{}, {}));
  HairAsset uneven = makeAsset();
  uneven.vertexCounts = {8, 8, 1, 8, 8};
  expectError(uneven.process(), "strand 2 has 1 vertices");
  EXPECT_EQ(scene_.resources().count(), 0u);
}

TEST(LookAt, PutsTheTargetInTheMiddleAtTheExpectedDepth) {
  for (const bool reversed : {false, true}) {
    const Matrix4 m = lookAt({1, 2, 5}, {1, 2, 0}, {0, 1, 0}, 1.0f, 1.5f, 0.1f, 100.0f, reversed);
    const auto row = [&](int i, Float3 p) {
      const Float4 r = m.rows[i];
      return r.x * p.x + r.y * p.y + r.z * p.z + r.w;
    };
    EXPECT_NEAR(row(0, {1, 2, 0}) / row(3, {1, 2, 0}), 0, 1e-6);
    EXPECT_NEAR(row(1, {1, 2, 0}) / row(3, {1, 2, 0}), 0, 1e-6);
    EXPECT_NEAR(row(3, {1, 2, 0}), 5, 1e-5);
    EXPECT_GT(row(1, {1, 3, 0}), 0);  // y up
    EXPECT_GT(row(0, {2, 2, 0}), 0);  // x to the right
    const Float3 nearPoint = {1, 2, 4.9f};
    EXPECT_NEAR(row(2, nearPoint) / row(3, nearPoint), reversed ? 1 : 0, 1e-4);
  }
}

TEST_F(SceneTest, AShiftOfTheOriginIsInTheListThatComesNext) {
  HairObject& hair = add();
  hair.drawnStrands = hair.strandCount();
  ASSERT_TRUE(scene_.shiftOrigin({5, 0, 0}));
  EXPECT_EQ(findPass(simulate(), "rewrite_classic_positions"), nullptr) << "there is nothing yet";
  const View view = {.width = 64, .height = 64};
  const auto rewrites = [&](const PassList& list) {
    return countPasses(list, "rewrite_classic_positions");
  };
  const auto shift = [&] { ASSERT_TRUE(scene_.shiftOrigin({0.5f, -0.25f, 8})); };
  shift();
  EXPECT_EQ(rewrites(simulate(0)), 1u);
  EXPECT_EQ(rewrites(simulate(0)), 0u);
  shift();
  EXPECT_EQ(rewrites(simulate()), 1u);
  shift();
  PassList list;
  ASSERT_TRUE(scene_.castShadows({}, list));
  EXPECT_EQ(rewrites(list), 1u);
  shift();
  ASSERT_TRUE(scene_.drawContacts(id_, view, {}, list));
  EXPECT_EQ(rewrites(list), 2u);
  scene_.finish(list);
  setDelivered(list.run);
  shift();
  // A draw that is refused leaves it to the next one.
  View broken = view;
  broken.eye.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(scene_.draw(broken, {}, list));
  EXPECT_EQ(rewrites(list), 2u);
  View seen = view;
  seen.worldToClip.rows[3] = {0, 0, 0, 1000};
  seen.worldToClip.rows[2] = {0, 0, 0.1f, 500};
  std::vector<PassList> lists(1);
  ASSERT_TRUE(scene_.draw(seen, {}, {.method = Transparency::kStochastic}, lists));
  EXPECT_EQ(rewrites(lists[0]), 1u);
  // The draws did not run.
  EXPECT_EQ(rewrites(simulate(0)), 1u);
  shift();
  ASSERT_TRUE(scene_.draw(seen, {}, {.method = Transparency::kStochastic}, lists));
  EXPECT_EQ(rewrites(lists[0]), 2u) << "the list was not cleared";
  scene_.finish(lists[0]);
  setDelivered(lists[0].run);
  EXPECT_EQ(rewrites(simulate(0)), 0u);
  // A reset writes everything.
  shift();
  hair.reset();
  EXPECT_EQ(rewrites(simulate()), 0u);
  EXPECT_EQ(rewrites(simulate(0)), 0u);
}

TEST_F(SceneTest, AShiftThatIsAbsurdChangesNothing) {
  add();
  simulate();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInf, -kInf, 1.7e7f, -1e30f}) {
    for (const Float3& shift : {Float3{bad, 0, 0}, Float3{1, bad, 0}, Float3{1, 1, bad}}) {
      expectError(scene_.shiftOrigin(shift), {"shiftOrigin()", "16777216"});
    }
  }
  EXPECT_EQ(countPasses(simulate(0), "rewrite_classic_positions"), 0u);
  EXPECT_TRUE(scene_.shiftOrigin({16777216, -16777216, 0}));
}

TEST_F(SceneTest, BonesOfASkeletonAreThoseInTheShiftedWorld) {
  const Result<SkeletonId> id = required(scene_.addSkeleton({}));
  AffineTransform bone;
  bone.rows[0].w = 100;
  scene_.skeleton(*id).setBones({&bone, 1});
  ASSERT_TRUE(scene_.shiftOrigin({99, 1, -2}));
  EXPECT_EQ(scene_.skeleton(*id).bones()[0].rows[0].w, 1);
  EXPECT_EQ(scene_.skeleton(*id).bones()[0].rows[1].w, -1);
  EXPECT_EQ(scene_.skeleton(*id).bones()[0].rows[2].w, 2);
}

}  // namespace
}  // namespace pelage::test
