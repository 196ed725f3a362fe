// The exact solver's passes of a scene, without a GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/scene.h"
#include "pelage/skeleton.h"
#include "simulation/exact_solver.h"
#include "support/not_numbers.h"
#include "support/scene_list_test.h"
#include "support/scene_run.h"

namespace pelage {
namespace {

using test::expectError;
using test::kNan;
using test::makeAsset;
using test::required;
using test::setBone;
using test::setCollider;

constexpr float kFrame = 1.0f / 60;

class ExactSceneTest : public test::SceneListTest {
 protected:
  HairObject& add(const HairDef& def = {}) { return addHair(def, asset_); }
  /// trim() frees buffers that the last frame did not use.
  void expectGone(std::initializer_list<BufferId> buffers) {
    for (const BufferId buffer : buffers) EXPECT_NE(scene_.resources().find(buffer), nullptr);
    scene_.trim();
    for (const BufferId buffer : buffers) EXPECT_EQ(scene_.resources().find(buffer), nullptr);
  }
  std::vector<ExactConstants> constants(std::string_view name = "simulate_exact") const {
    return constantsOf<ExactConstants>(name);
  }
  std::vector<ContactConstants> contactConstants() const {
    return constantsOf<ContactConstants>("find_contacts");
  }
  SimulateExactKey plainKey() const { return {.velocityShockPropagation = true}; }
  const KernelVariant* variant() const { return passes("simulate_exact").at(0)->kernel; }
  std::vector<Collider> uploadedColliders(const HairObject& hair) const {
    return uploaded<Collider>(hair.buffers().colliders);
  }

  HairAsset asset_ = makeAsset();
};

TEST_F(ExactSceneTest, IsTheDefaultAndNeedsTwoPassesAndOneThatSeeksWhatIsAwake) {
  HairObject& hair = add();
  simulate();
  ASSERT_EQ(list_.passes.size(), 3u);
  EXPECT_STREQ(list_.passes[0].name, "skin_roots");
  EXPECT_STREQ(list_.passes[1].name, "select_awake_tiles");
  EXPECT_STREQ(list_.passes[2].name, "simulate_exact");
  EXPECT_EQ(list_.passes[2].kind, PassKind::kDispatchIndirect);
  hair.settings.sleep.enabled = false;
  simulate();
  ASSERT_EQ(list_.passes.size(), 2u);
  EXPECT_STREQ(list_.passes[1].name, "simulate_exact");
  EXPECT_EQ(list_.passes[1].kind, PassKind::kDispatch);
  EXPECT_EQ(hair.buffers().colliders, BufferId::kInvalid);
}

TEST_F(ExactSceneTest, AShiftOfTheOriginIsOnePassInTheNextListAlone) {
  add();
  simulate();
  ASSERT_TRUE(scene_.shiftOrigin({100, -0.5f, 3}));
  ASSERT_TRUE(scene_.shiftOrigin({1, 0, 0}));
  simulate();
  ASSERT_EQ(list_.passes.size(), 4u);
  EXPECT_STREQ(list_.passes[0].name, "rewrite_exact_positions");
  simulate();
  EXPECT_EQ(list_.passes.size(), 2u) << "the bones stand still";
  EXPECT_TRUE(passes("rewrite_exact_positions").empty());
}

TEST_F(ExactSceneTest, WhatIsSwitchedOffIsNotInThePermutationOrHasNoStrength) {
  HairObject& hair = add();
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant(plainKey()));
  const uint64_t rest = scene_.resources().find(hair.buffers().rest)->size;

  hair.settings.globalStiffness = 0.1f;
  simulate();
  EXPECT_EQ(variant(),
            &simulateExactVariant({.globalShape = true, .velocityShockPropagation = true}));
  const uint64_t strands = hair.guideCount() * sizeof(ExactStrand);
  EXPECT_EQ(scene_.resources().find(hair.buffers().rest)->size, 2 * (rest - strands) + strands);
  EXPECT_EQ(constants().at(0).flags & 1u, 0u) << "the hair goes on as it was";

  hair.settings.globalRange = 0;
  hair.settings.vspCoefficient = 0;
  hair.settings.vspThreshold = std::numeric_limits<float>::infinity();
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant({}));
  EXPECT_EQ(scene_.resources().find(hair.buffers().rest)->size, rest);

  EXPECT_EQ(constants().at(0).damping, 0.0f);

  hair.settings.relaxationTime = 1e-3f;
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant({}));
  EXPECT_GT(constants().at(0).damping, 0.0f);
}

TEST_F(ExactSceneTest, ShockPropagationGoesOnFromTheStateThatIsThere) {
  HairObject& hair = add();
  hair.settings.vspCoefficient = 0;
  hair.settings.vspThreshold = std::numeric_limits<float>::infinity();
  simulate();
  simulate();
  EXPECT_NE(constants().at(0).historyShare, 0.0f);
  hair.settings.vspCoefficient = 0.5f;
  simulate();
  EXPECT_NE(constants().at(0).historyShare, 0.0f);
  EXPECT_EQ(constants().at(0).rotationRatio, 1.0f);
}

TEST_F(ExactSceneTest, HeldVerticesNeedTheirGoals) {
  asset_.positions[7].w = 0;
  ASSERT_TRUE(asset_.process());
  add();
  simulate();
  EXPECT_TRUE(variant() ==
              &simulateExactVariant({.globalShape = true, .velocityShockPropagation = true}));
}

TEST_F(ExactSceneTest, SubStepsCoverTheFrameOnceAndTakeTurnsWithTheState) {
  HairObject& hair = add();
  hair.settings.subSteps = 2;
  simulate(1.0f / 20);
  const std::vector<ExactConstants> first = constants();
  ASSERT_EQ(first.size(), 6u);
  simulate(1.0f / 20);
  std::vector<ExactConstants> all = first;
  for (const ExactConstants& c : constants()) all.push_back(c);
  float end = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].slot, i % 4);
    EXPECT_EQ(all[i].rootBegin, end);
    end = all[i].rootEnd == 1 ? 0 : all[i].rootEnd;
    EXPECT_EQ(all[i].flags, (i == 0 ? 33u : 0u) | (i % 6 == 5 ? 2u : 0u) | 8u);
    // BDF2 from the second step on: he = 2/3 h.
    EXPECT_NEAR(all[i].inverseStep, i == 0 ? 120.0f : 180.0f, 0.01f);
  }
}

TEST_F(ExactSceneTest, ResetForgetsTheHistory) {
  HairObject& hair = add();
  simulate();
  simulate();
  hair.reset();
  simulate();
  EXPECT_EQ(constants().at(0).flags, 43u);
  EXPECT_EQ(constants().at(0).historyShare, 0.0f);
}

TEST_F(ExactSceneTest, DampingAndGlobalShapeDoNotDependOnTheStep) {  // K16
  HairObject& hair = add();
  hair.settings.damping = 0.2f;
  hair.settings.globalStiffness = 0.3f;
  hair.settings.gravity = {0, -9, 0};
  for (const float dt : {kFrame, kFrame / 4}) {
    hair.reset();
    simulate(dt);
    const ExactConstants c = constants().at(0);
    const double h = static_cast<double>(dt);
    // weight = 1 / h^2 + c / h without history.
    const double drag = (static_cast<double>(c.weight) - 1 / (h * h)) * h;
    EXPECT_NEAR(std::exp(-drag / 60), 0.8, 1e-4);
    EXPECT_NEAR(c.targetStiffness, 0.3f / 0.7f * 3600, 0.1f);
    EXPECT_NEAR(c.drift.y * c.weight, -9, 1e-3);
  }
}

TEST_F(ExactSceneTest, TheOriginFollowsTheHairInWholeMetres) {
  HairObject& hair = add();
  simulate();
  AffineTransform bone;
  float origin = 0;
  for (int frame = 1; frame <= 40; ++frame) {
    const float x = 0.3f * static_cast<float>(frame);
    bone.rows[0].w = x;
    setBone(hair, bone);
    simulate();
    const ExactConstants c = constants().at(0);
    EXPECT_LE(std::abs(c.origin.x - x), 1.7f);
    EXPECT_EQ(c.origin.x, std::round(c.origin.x));
    EXPECT_EQ(c.rebase.x, origin - c.origin.x);
    EXPECT_EQ((c.flags & 4u) != 0, c.origin.x != origin);
    // The bone that the kernel sees is relative to the origin.
    Float4 row = {};
    ASSERT_EQ(list_.uploads.at(0).buffer, hair.buffers().boneTransforms);
    std::memcpy(&row, list_.uploadData.data() + list_.uploads[0].dataOffset, sizeof(row));
    EXPECT_EQ(row.w, x - c.origin.x);
    origin = c.origin.x;
  }
  EXPECT_GE(origin, 10);
}

TEST_F(ExactSceneTest, CollidersThatNoStrandReachesAreLeftOut) {  // K34
  HairObject& hair = add();
  const CapsuleCollider far = {
      .head = {9, 0, 0}, .headRadius = 1, .tail = {9, 1, 0}, .tailRadius = 1};
  const CapsuleCollider near = {.head = {0, -0.5f, 0},
                                .headRadius = 0.4f,
                                .tail = {0, -0.5f, 0},
                                .tailRadius = 0.4f,
                                .friction = 0.7f};
  const CapsuleCollider broken = {.head = {0, kNan, 0}, .headRadius = 1};
  const CapsuleCollider negative = {.headRadius = -1};
  hair.setColliders({{far, broken, negative}});
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant(plainKey()));
  EXPECT_EQ(passes("simulate_exact").size(), 1u);
  EXPECT_TRUE(passes("find_contacts").empty());
  EXPECT_EQ(hair.buffers().colliders, BufferId::kInvalid);
  EXPECT_EQ(hair.buffers().contacts, BufferId::kInvalid);
  EXPECT_EQ(hair.buffers().contactWords, BufferId::kInvalid);

  hair.setColliders({{far, broken, negative, near}});
  simulate();
  EXPECT_TRUE(passes("simulate_exact").empty());
  const std::vector<Collider> colliders = uploadedColliders(hair);
  ASSERT_EQ(colliders.size(), 1u);
  EXPECT_EQ(colliders[0].head, (Float4{0, -0.5f, 0, 0.4f}));
  EXPECT_EQ(colliders[0].headBefore, (Float4{0, -0.5f, 0, 0.7f}));
  EXPECT_EQ(constants("eliminate_strands").at(0).colliderCount, 1u);
  EXPECT_EQ(contactConstants().at(0).capsuleCount, 1u);

  setCollider(hair, far);
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant(plainKey()));
  EXPECT_TRUE(passes("find_contacts").empty());
}

// Contacts are found for the tiles that are awake before the step, and once more for the strands
// that are solved again. A reset needs its pose first.
TEST_F(ExactSceneTest, ContactsAreFoundBeforeAStepAndAgainAfterIt) {
  constexpr uint32_t kListed = 1, kAgain = 2, kNoHistory = 4;
  HairObject& hair = add();
  const CapsuleCollider ball = {.headRadius = 0.1f, .tailRadius = 0.1f};
  setCollider(hair, ball);
  const auto names = [&] {
    std::vector<std::string> all;
    for (const Pass& pass : list_.passes) all.emplace_back(pass.name);
    return all;
  };
  using Names = std::vector<std::string>;
  simulate();
  const Names step = {"find_contacts", "eliminate_strands", "solve_contacts", "roll_out_strands",
                      "find_contacts", "eliminate_strands", "solve_contacts", "roll_out_strands"};
  Names expected = {"skin_roots", "select_awake_tiles", "eliminate_strands"};
  expected.insert(expected.end(), step.begin(), step.end());
  EXPECT_EQ(names(), expected);
  const auto eliminations = [&] { return constants("eliminate_strands"); };
  EXPECT_EQ(eliminations().at(0).flags & (1u | 128u | 256u), 1u | 256u);
  EXPECT_EQ(eliminations().at(1).flags & (1u | 128u | 256u), 1u);
  EXPECT_EQ(eliminations().at(2).flags & (1u | 128u | 256u), 1u | 128u);
  EXPECT_EQ(contactConstants().at(0).contactFlags & 7u, kListed | kNoHistory);
  EXPECT_EQ(contactConstants().at(1).contactFlags & 7u, kAgain);

  simulate();
  expected.erase(expected.begin() + 2);
  EXPECT_EQ(names(), expected);
  for (const std::string& name : step) {
    for (const Pass* pass : passes(name)) EXPECT_EQ(pass->kind, PassKind::kDispatchIndirect);
  }
  EXPECT_EQ(contactConstants().at(0).contactFlags & 7u, kListed);
  EXPECT_EQ(eliminations().at(0).slot, eliminations().at(1).slot) << "the same step once more";
  EXPECT_EQ(eliminations().at(1).flags & 128u, 128u);

  hair.settings.sleep.enabled = false;
  hair.settings.subSteps = 2;
  simulate();
  EXPECT_EQ(passes("find_contacts").size(), 4u);
  for (const std::string& name : step) {
    ASSERT_EQ(passes(name).size(), 4u) << name;
    EXPECT_EQ(passes(name).at(0)->kind,
              name == "solve_contacts" ? PassKind::kDispatchIndirect : PassKind::kDispatch);
    EXPECT_EQ(passes(name).at(1)->kind, PassKind::kDispatchIndirect);
  }
  // Each sub-step has a head of its own, and its part of the frame.
  const std::vector<ContactConstants> found = contactConstants();
  ASSERT_EQ(found.size(), 4u);
  EXPECT_NE(found[0].contactHead, found[2].contactHead);
  EXPECT_EQ(found[0].contactHead, found[1].contactHead);
  EXPECT_EQ(found[0].contactHead, eliminations().at(0).contactHead);
  EXPECT_EQ(found[2].contactHead, eliminations().at(2).contactHead);
  EXPECT_EQ(found[0].contactBegin, 0.0f);
  EXPECT_EQ(found[0].contactEnd, found[2].contactBegin);
  EXPECT_EQ(found[2].contactEnd, 1.0f);
  // Both sub-steps are as long as each other.
  EXPECT_NEAR(found[0].contactRatio, 0.5, 1e-6);
  EXPECT_NEAR(found[2].contactRatio, 1, 1e-6);

  // Old contacts are not continued.
  hair.setColliders({});
  simulate();
  EXPECT_TRUE(passes("find_contacts").empty());
  setCollider(hair, ball);
  simulate();
  EXPECT_EQ(contactConstants().at(0).contactFlags & kNoHistory, kNoHistory);
}

// Arguments of find_contacts over the tiles that are awake.
TEST_F(ExactSceneTest, TheHeadOfSleepHasWhatIndirectPassesTake) {
  HairObject& hair = add();
  setCollider(hair, {.headRadius = 0.1f, .tailRadius = 0.1f});
  simulate();
  // Sixteen words, a tile with its offset, five strands.
  EXPECT_EQ(scene_.resources().find(hair.buffers().sleep)->size, (16u + 2 + 5) * 4);
  const std::vector<uint32_t> head = uploaded<uint32_t>(hair.buffers().sleep);
  ASSERT_EQ(head.size(), 16u);
  // A tile is four groups of eight strands in the elimination, and two of sixteen strands in the
  // search for contacts.
  EXPECT_EQ(head, (std::vector<uint32_t>{0, 4, 1, 0, 0, head[5], 1, 0, 0, 2, 1, 0, 0, 0, 0, 0}));
}

TEST_F(ExactSceneTest, CollidersMoveFromWhereTheyWere) {
  HairObject& hair = add();
  CapsuleCollider ball = {.headRadius = 0.1f, .tailRadius = 0.1f};
  setCollider(hair, ball);
  simulate();
  ball.head.x = ball.tail.x = 0.0625f;
  setCollider(hair, ball);
  simulate();
  const std::vector<Collider> colliders = uploadedColliders(hair);
  ASSERT_EQ(colliders.size(), 1u);
  EXPECT_EQ(colliders[0].headBefore.x, 0.0f);
  EXPECT_EQ(colliders[0].head.x, 0.0625f);
  simulate();
  EXPECT_EQ(uploadedColliders(hair).at(0).headBefore.x, 0.0625f);
}

TEST_F(ExactSceneTest, RootsThatStandStillAreSkinnedTwice) {
  HairObject& hair = add();
  for (const size_t expected : {1, 1, 0, 0}) {
    simulate();
    EXPECT_EQ(passes("skin_roots").size(), expected);
  }
  AffineTransform bone;
  bone.rows[1].w = 0.01f;
  setBone(hair, bone);
  for (const size_t expected : {1, 1, 0}) {
    simulate();
    EXPECT_EQ(passes("skin_roots").size(), expected);
  }
  hair.reset();
  simulate();
  EXPECT_EQ(passes("skin_roots").size(), 1u);
}

TEST_F(ExactSceneTest, WhatMovesAllHairWakesAllOfIt) {
  constexpr uint32_t kWakeAll = 16;
  HairObject& hair = add();
  const auto wakes = [&] {
    simulate();
    return constants("select_awake_tiles").at(0).flags == kWakeAll;
  };
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
  hair.settings.gravity.x = 0.1f;
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
  hair.reset();
  EXPECT_TRUE(wakes());
  hair.settings.curves.stiffness[3] = 2;
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
  CapsuleCollider ball = {.headRadius = 0.05f, .tailRadius = 0.05f};
  setCollider(hair, ball);
  EXPECT_TRUE(wakes());
  ball.head.x = ball.tail.x = 0.01f;
  setCollider(hair, ball);
  EXPECT_FALSE(wakes()) << "the kernel sees which strands a motion reaches";
  ball.headRadius = 0.04f;
  setCollider(hair, ball);
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
  ball.head.x = kNan;
  setCollider(hair, ball);
  EXPECT_TRUE(wakes()) << "what it rested on is gone";
  ball.head.x = 0;
  setCollider(hair, ball);
  EXPECT_TRUE(wakes());
  hair.setColliders({});
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
  // Gusts keep it awake; a steady wind does not.
  hair.settings.wind.velocity = {1, 0, 0};
  simulate();
  EXPECT_TRUE(passes("select_awake_tiles").empty());
  hair.settings.wind.gustStrength = 0;
  EXPECT_TRUE(wakes());
  EXPECT_FALSE(wakes());
}

TEST_F(ExactSceneTest, TakesForcesOnlyFromABufferThatIsLargeEnough) {
  HairObject& hair = add();
  const BufferId small = scene_.resources().add({.name = "small", .size = 16, .stride = 16});
  hair.setForces(small);
  expectRefused({"has 16 bytes; it takes 640"});
  hair.setForces(scene_.resources().add({.name = "forces", .size = 640, .stride = 16}));
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant({.velocityShockPropagation = true, .forces = true}));
  hair.setForces(BufferId::kInvalid);
  simulate();
  EXPECT_EQ(variant(), &simulateExactVariant(plainKey()));
}

// Bones, a reset and the wind's phase wait for a frame that is not refused.
TEST_F(ExactSceneTest, AFrameThatIsRefusedLosesNothing) {
  HairObject& first = add();
  HairObject& second = add({.name = "second"});
  simulate();
  setBone(first, rigidTransform({0, 0, 0, 1}, {0, 0.25f, 0}));
  first.reset();
  const double time = scene_.time();
  const auto refused = [&] {
    const Result<void> done = scene_.simulate(kFrame, list_);
    EXPECT_FALSE(done);
    EXPECT_TRUE(list_.passes.empty() && list_.uploads.empty());
    EXPECT_EQ(scene_.time(), time);
  };
  second.simulatedShare = 0.5f;
  refused();
  second.simulatedShare = 1;
  second.settings.damping = kNan;
  refused();
  second.settings.damping = 0.1f;
  second.setForces(scene_.resources().add({.name = "small", .size = 16, .stride = 16}));
  refused();
  second.setForces(BufferId::kInvalid);
  simulate();
  EXPECT_FALSE(uploaded<Float4>(first.buffers().boneTransforms).empty());
  EXPECT_EQ(constants().at(0).flags & 1u, 1u) << "the reset";
}

TEST_F(ExactSceneTest, LevelOfDetailCostsWhatIsSimulated) {  // K44
  asset_ = makeAsset(640, 4);
  HairObject& hair = add({.levelOfDetail = true});
  hair.settings.sleep.enabled = false;
  hair.simulatedShare = 0.25f;
  simulate();
  EXPECT_EQ(passes("simulate_exact").at(0)->groups[0], 5u);
  EXPECT_EQ(passes("interpolate_guides").size(), 1u);
  hair.simulatedShare = 1;
  for (int frame = 0; frame < 15; ++frame) simulate();
  EXPECT_EQ(passes("simulate_exact").at(0)->groups[0], 20u);
  simulate();
  EXPECT_EQ(passes("interpolate_guides").size(), 0u) << "nothing left to interpolate";

  hair.simulatedShare = 1.5f;
  EXPECT_FALSE(scene_.simulate(kFrame, list_));
  HairObject& plain = add({.name = "plain"});
  hair.simulatedShare = 1;
  plain.simulatedShare = 0.5f;
  expectRefused({"HairDef::levelOfDetail"});
  EXPECT_EQ(plain.buffers().lodParents, BufferId::kInvalid);
}

TEST_F(ExactSceneTest, CurvesAndStrandFactorsAreOneMoreSetOfTheRestShape) {
  HairObject& hair = add();
  simulate();
  EXPECT_EQ(constants().at(0).parameterSet, 0u);
  hair.settings.curves.stiffness = {1, 1, 1, 1, 1, 1, 1, 3};
  hair.settings.globalStiffness = 0.1f;
  simulate();
  EXPECT_EQ(constants().at(0).parameterSet, 2u);
  hair.settings.curves.stiffness[0] = -1;
  expectRefused({"'curves.stiffness' is -1"});

  const std::vector<StrandFactors> factors(4);
  EXPECT_FALSE(scene_.addHair(asset_, {.strandFactors = factors}));
  const std::vector<StrandFactors> wrong(5, {.damping = kNan});
  EXPECT_FALSE(scene_.addHair(asset_, {.strandFactors = wrong}));
}

TEST(ParameterCurve, IsLinearBetweenItsValues) {
  const ParameterCurve curve = {0, 1, 2, 3, 4, 5, 6, 14};
  EXPECT_FLOAT_EQ(valueAt(curve, 0), 0);
  EXPECT_FLOAT_EQ(valueAt(curve, 0.5f), 3.5f);
  EXPECT_FLOAT_EQ(valueAt(curve, 1), 14);
  EXPECT_FLOAT_EQ(valueAt(curve, 6.5f / 7), 10);
}

TEST_F(ExactSceneTest, SwitchingTheSolverReplacesItsBuffersOnly) {
  HairObject& hair = add();
  simulate();
  const HairBuffers exact = hair.buffers();
  const uint64_t bytes = scene_.resources().totalBytes();
  hair.settings.solver = Solver::kClassic;
  simulate();
  EXPECT_EQ(passes("simulate_exact").size(), 0u);
  EXPECT_EQ(passes("simulate_classic").size(), 1u);
  EXPECT_EQ(hair.buffers().positions, exact.positions);
  expectGone({exact.rest, exact.state});
  EXPECT_LT(scene_.resources().totalBytes(), bytes);
  hair.settings.solver = Solver::kExact;
  simulate();
  scene_.trim();
  EXPECT_EQ(scene_.resources().totalBytes(), bytes);
  EXPECT_EQ(constants().at(0).flags & 1u, 1u);
}

// The strands of the two solvers are in another order.
TEST_F(ExactSceneTest, SwitchingTheSolverReplacesTheContacts) {
  HairObject& hair = add();
  setCollider(hair, {.headRadius = 1, .tailRadius = 1});
  simulate();
  const HairBuffers exact = hair.buffers();
  const uint64_t bytes = scene_.resources().totalBytes();
  hair.settings.solver = Solver::kClassic;
  simulate();
  expectGone({exact.contacts, exact.contactWords});
  EXPECT_EQ(passes("find_contacts").size(), 0u) << "a reset takes the goals";
  simulate();
  EXPECT_EQ(passes("find_contacts").size(), 1u);
  EXPECT_EQ(passes("find_contacts").at(0)->kind, PassKind::kDispatch);
  EXPECT_EQ(passes("simulate_classic").size(), 1u);
  EXPECT_EQ(passes("simulate_classic").at(0)->kernel, &simulateClassicVariant({.contacts = true}));
  hair.settings.solver = Solver::kExact;
  simulate();
  scene_.trim();
  EXPECT_EQ(scene_.resources().totalBytes(), bytes);
}

TEST_F(ExactSceneTest, RemovingAnObjectFreesItsBuffers) {
  const Result<HairId> id = required(scene_.addHair(asset_, {}));
  setCollider(scene_.hair(*id), {.headRadius = 1, .tailRadius = 1});
  simulate();
  const HairBuffers buffers = scene_.hair(*id).buffers();
  EXPECT_NE(scene_.resources().find(buffers.contacts), nullptr);
  EXPECT_NE(scene_.resources().find(buffers.contactWords), nullptr);
  EXPECT_TRUE(scene_.removeHair(*id));
  EXPECT_EQ(scene_.resources().totalBytes(), 0u);
}

TEST_F(ExactSceneTest, StrandsOfDifferentCountsAreSortedIntoTiles) {
  asset_ = makeAsset(40, 8);
  asset_.vertexCounts.resize(40);
  for (uint32_t s = 0; s < 40; ++s) asset_.vertexCounts[s] = 2 + s % 7;
  ASSERT_TRUE(asset_.process());
  const HairObject& hair = add();
  const BufferDesc* desc = scene_.resources().find(hair.buffers().rest);
  std::vector<ExactStrand> strands(40);
  const size_t bytes = strands.size() * sizeof(ExactStrand);
  ASSERT_GT(desc->size, bytes);
  std::memcpy(strands.data(), desc->initial.data() + desc->size - bytes, bytes);
  std::vector<bool> seen(40);
  for (size_t i = 0; i < strands.size(); ++i) {
    EXPECT_EQ(strands[i].count, asset_.vertexCounts[strands[i].root]);
    EXPECT_EQ(strands[i].target, strands[i].root * 8);
    EXPECT_EQ(strands[i].state % 32, i % 32);
    if (i > 0) {
      EXPECT_GE(strands[i].count, strands[i - 1].count);
    }
    seen[strands[i].root] = true;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 40);
  // Two tiles, as long as their longest strands.
  EXPECT_EQ(scene_.resources().find(hair.buffers().rest)->size,
            32u * sizeof(Float4) * (strands[31].count + strands[39].count) + bytes);
}

}  // namespace
}  // namespace pelage
