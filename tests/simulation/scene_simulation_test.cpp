// The simulation of a whole scene, with both solvers on every API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "pelage/demo/groom.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/scene_test.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

class SceneSimulation : public SolverTest {};

AffineTransform shifted(double x) {
  AffineTransform bone;
  bone.rows[0].w = static_cast<float>(x);
  return bone;
}

SimulationSettings calmSettings() {
  SimulationSettings settings;
  settings.damping = 0.3f;
  settings.vspCoefficient = 0;
  return settings;
}

TEST_P(SceneSimulation, TheBindPoseWithoutGravityStays) {  // K4
  const HairAsset asset = wavyAsset(40, 12);
  settings_.gravity = {};
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 60; ++frame) run_.step();
  const std::vector<Float4> first = run_.positions(hair);
  for (int frame = 0; frame < 60; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(hair);
  EXPECT_LT(maxDistance(positions, asset.positions), 1e-5) << "of strands of 0.3 m";
  EXPECT_LT(maxDistance(positions, first), 1e-5);
}

TEST_P(SceneSimulation, AWalkOfHundredMetresIsTheMotionThatTheGroundDoesNotSee) {
  // Two runs with the same steps of the head; one starts 1 km away, where a float is 6e-5 m.
  const HairAsset asset = wavyAsset(33, 16);
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  const HairObject& away = run_.add(asset, {.name = "away", .settings = settings_});
  for (int frame = 0; frame < 120; ++frame) {
    // 16 m/s in steps that a float holds exactly.
    const double x = 0.25 * frame;
    for (const auto& [object, start] :
         {std::pair<const HairObject*, double>{&hair, 0}, {&away, 1024}}) {
      setBone(*const_cast<HairObject*>(object), shifted(start + x));
    }
    run_.step();
  }
  const std::vector<Float4> here = run_.positions(hair), there = run_.positions(away);
  EXPECT_LT(maxDistance(here, there, {.shift = {-1024, 0, 0}}), 1e-4)
      << "the output's rounding at 1 km is 6e-5 m";
  EXPECT_LT(maxStretch(asset, here), 1e-3);
}

TEST_P(SceneSimulation, HairInContactDoesNotFeelTheOriginFollowIt) {
  // Hair and a ball that it lies on go on and on at the same speed and come to rest beside each
  // other, but for the few strands of the classic solver that flutter. The origin goes with them in
  // steps of a metre or two: nothing stirs anew.
  settings_.damping = 0.9f;
  settings_.sleep.enabled = false;
  const HairAsset asset = wavyAsset(33, 16);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  std::vector<Float4> before;
  double earlier = 0, later = 0;  // largest motion in a frame
  for (int frame = 0; frame < 150; ++frame) {
    const float x = 0.0625f * static_cast<float>(frame);
    setBone(hair, shifted(static_cast<double>(x)));
    const Float3 at = {x, -0.25f, 0};
    setCollider(hair, {.head = at, .headRadius = 0.1f, .tail = at, .tailRadius = 0.1f});
    run_.step();
    if (frame < 80) continue;
    std::vector<Float4> now = run_.positions(hair);
    for (size_t i = 0; i < now.size(); ++i) {
      now[i].x -= x;
      if (!before.empty()) keepLargest(frame < 90 ? earlier : later, distance(now[i], before[i]));
    }
    before = now;
  }
  EXPECT_LT(earlier, exact() ? 1e-3 : 0.01);
  EXPECT_LT(later, 1.1 * earlier);
}

TEST_P(SceneSimulation, TurnsWithTheSolverInTheMiddleOfARun) {
  const HairAsset asset = wavyAsset(20, 9);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 5; ++frame) run_.step();
  hair.settings.solver = exact() ? Solver::kClassic : Solver::kExact;
  run_.step();
  EXPECT_LT(maxStretch(asset, run_.positions(hair)), 1e-4);
  hair.settings.solver = settings_.solver;
  hair.settings.globalStiffness = 0.1f;
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_LT(maxStretch(asset, run_.positions(hair)), 1e-4);
}

TEST_P(SceneSimulation, StrandsOfDifferentCountsShareAnObject) {
  HairAsset asset = wavyAsset(70, 12);
  asset.vertexCounts.resize(70);
  for (uint32_t s = 0; s < 70; ++s) asset.vertexCounts[s] = 2 + (s * 7) % 11;
  expectOk(asset.process());
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 30; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(hair);
  EXPECT_LT(maxStretch(asset, positions), 1e-4);
  for (uint32_t s = 0; s < 70; ++s) {
    const size_t first = size_t{12} * s, tip = first + asset.vertexCounts[s] - 1;
    for (size_t i = tip; i < first + 12; ++i)
      EXPECT_LT(distance(positions[i], positions[tip]), exact() ? 1e-30 : 1e-4) << "strand " << s;
  }
}

TEST_P(SceneSimulation, ForcesOfABufferActLikeGravityAndWind) {
  const HairAsset asset = wavyAsset(10, 12);
  SimulationSettings plain = settings_;
  plain.airDrag = 0;  // of the classic solver, whose wind is not a force on all of a vertex
  if (exact())
    plain.wind = {.velocity = {2, 0, 1}, .gustStrength = 0, .strandVariation = 0};
  else
    plain.gravity = {2, -9.81f, 1};
  plain.damping = exact() ? 0.1f : 0;
  HairObject& expected = run_.add(asset, {.settings = plain});
  // The same from forces: no gravity, no damping and no wind in the settings.
  SimulationSettings none = plain;
  none.gravity = {};
  none.damping = 0;
  none.wind = {};
  HairObject& forced = run_.add(asset, {.name = "forced", .settings = none});
  const float drag = -60 * std::log(0.9f);
  const std::vector<Float4> force(
      120, exact() ? Float4{2 * drag, -9.81f, drag, drag} : Float4{2, -9.81f, 1, 0});
  forced.setForces(run_.add("forces", force));
  // Until both hang in the wind: on the way there the two take second Newton passes at different
  // times, which go by the drag of the settings.
  for (int frame = 0; frame < (exact() ? 300 : 30); ++frame) run_.step();
  const std::vector<Float4> a = run_.positions(expected), b = run_.positions(forced);
  EXPECT_LT(maxDistance(a, b), 1e-4);
  EXPECT_GT(maxDistance(a, asset.positions), 0.02);
}

TEST_P(SceneSimulation, DragOfABufferSlowsTheFall) {
  // A step from rest: he^2 a / (1 + k he), he = h for the classic solver and 2 h / 3 for the exact
  // one. The first frame puts the hair into its place.
  const HairAsset asset = strandsAt(2, 3, [](uint32_t s, uint32_t v) {
    return Float3{0.1f * static_cast<float>(v), 0, 0.1f * static_cast<float>(s)};
  });
  settings_.gravity = {};
  settings_.damping = 0;
  settings_.bendLength = 0;
  settings_.localStiffness = 0;
  HairObject& hair = run_.add(asset, {.settings = settings_});
  run_.step();
  std::vector<Float4> force(6, {0, -4, 0, 0});
  for (size_t v = 3; v < 6; ++v) force[v].w = 60;
  hair.setForces(run_.add("drag", force));
  run_.step();
  const std::vector<Float4> p = run_.positions(hair);
  const double share = exact() ? 2.0 / 3 : 1, fall = 4.0 / 3600 * share * share;
  EXPECT_NEAR(p[2].y, -fall, 0.02 * fall);
  EXPECT_NEAR(p[5].y, -fall / (1 + share), 0.02 * fall) << "k h = 1";
}

TEST_P(SceneSimulation, StiffnessCurvesAndStrandFactorsAct) {
  // Straight horizontal strands that sag.
  const HairAsset asset = strandsAt(3, 16, [](uint32_t s, uint32_t v) {
    return Float3{0.01f * static_cast<float>(v), 0, 0.05f * static_cast<float>(s)};
  });
  SimulationSettings settings = settings_;
  settings.bendLength = 0.05f;
  // The springs of the classic solver: s / (1 - s) is 1, and 4 times that with 0.8.
  settings.localStiffness = 0.5f;
  settings.damping = exact() ? 0.3f : 0.1f;
  if (!exact()) settings.gravity.y = -0.5f;
  const std::vector<StrandFactors> factors = {{}, {.stiffness = 4}, {.stiffness = 0.25f}};
  const HairObject& hair = run_.add(asset, {.settings = settings, .strandFactors = factors});
  SimulationSettings stiff = settings;
  stiff.bendLength = 0.05f * std::cbrt(4.0f);
  stiff.localStiffness = 0.8f;
  const HairObject& uniform = run_.add(asset, {.name = "uniform", .settings = stiff});
  SimulationSettings curved = settings;
  curved.curves.stiffness.fill(4);
  const HairObject& byCurve = run_.add(asset, {.name = "curve", .settings = curved});
  for (int frame = 0; frame < 120; ++frame) run_.step();
  const std::vector<Float4> p = run_.positions(hair);
  const float tip = run_.positions(uniform)[15].y;
  EXPECT_NEAR(p[16 + 15].y, tip, 1e-5) << "a strand factor is a stiffness";
  EXPECT_NEAR(run_.positions(byCurve)[15].y, tip, 1e-5) << "and so is a constant curve";
  EXPECT_LT(p[15].y, p[16 + 15].y - 0.005f);
  EXPECT_LT(p[32 + 15].y, p[15].y - 0.005f);
}

TEST_P(SceneSimulation, GlobalStiffnessAndDampingHaveCurvesToo) {
  HairAsset asset = wavyAsset(8, 10);
  settings_.globalRange = 1;
  settings_.globalStiffness = 0.2f;
  settings_.damping = 0.02f;
  const HairObject& plain = run_.add(asset, {.settings = settings_});
  SimulationSettings weak = settings_;
  weak.curves.globalStiffness.fill(0.2f);
  const HairObject& drooping = run_.add(asset, {.name = "weak", .settings = weak});
  SimulationSettings slow = settings_;
  slow.curves.damping.fill(20);
  const HairObject& damped = run_.add(asset, {.name = "slow", .settings = slow});
  // On the first way down, and when all have settled.
  for (int frame = 0; frame < 7; ++frame) run_.step();
  const auto furthest = [&](const HairObject& hair) {
    return maxDistance(run_.positions(hair), asset.positions);
  };
  EXPECT_LT(furthest(damped), 0.8 * furthest(plain));
  for (int frame = 0; frame < 200; ++frame) run_.step();
  EXPECT_GT(furthest(drooping), 1.5 * furthest(plain));
}

TEST_P(SceneSimulation, GustsDifferFromStrandToStrandAsMuchAsAskedFor) {
  // The same strand 20 times at different places.
  const HairAsset asset = strandsAt(20, 10, [](uint32_t s, uint32_t v) {
    return Float3{0.05f * static_cast<float>(s), -0.02f * static_cast<float>(v), 0};
  });
  double spread[2] = {};
  for (int k = 0; k < 2; ++k) {
    SimulationSettings settings = settings_;
    settings.airDrag = SimulationSettings().airDrag;
    settings.wind = {
        .velocity = {0, 0, 4}, .gustStrength = 1, .strandVariation = static_cast<float>(k)};
    const HairObject& hair =
        run_.add(asset, {.name = "hair" + std::to_string(k), .settings = settings});
    for (int frame = 0; frame < 40; ++frame) run_.step();
    const std::vector<Float4> p = run_.positions(hair);
    float low = p[9].z, high = p[9].z;
    for (size_t s = 0; s < 20; ++s) {
      keepSmallest(low, p[10 * s + 9].z);
      keepLargest(high, p[10 * s + 9].z);
    }
    spread[k] = static_cast<double>(high - low);
  }
  EXPECT_LT(spread[0], 1e-5);
  EXPECT_GT(spread[1], 0.005);
}

// ---- what only the exact solver has

class ExactScene : public SceneTest {
 protected:
  uint32_t awake(const HairObject& hair) const { return run_.awake(hair); }
  /// Steps until everything sleeps; the number of frames that took.
  int fallAsleep(const HairObject& hair) {
    for (int frame = 1; frame <= 900; ++frame) {
      run_.step();
      if (awake(hair) == 0) return frame;
    }
    ADD_FAILURE() << awake(hair) << " strands did not come to rest";
    return 0;
  }
};

TEST_P(ExactScene, HairAtRestSleepsWhereItIs) {
  const HairAsset asset = wavyAsset(70, 10);
  const HairObject& hair = run_.add(asset, {.settings = calmSettings()});
  run_.step();
  EXPECT_EQ(awake(hair), 70u);
  EXPECT_GT(fallAsleep(hair), 30) << "half a second of rest";
  const std::vector<Float4> before = run_.positions(hair);
  for (int frame = 0; frame < 10; ++frame) run_.step();
  const std::vector<Float4> after = run_.positions(hair);
  EXPECT_EQ(before, after);
  EXPECT_EQ(awake(hair), 0u);
}

TEST_P(ExactScene, SleepDoesNotChangeTheMotionAfterIt) {
  const HairAsset asset = wavyAsset(70, 10);
  HairObject& sleeper = run_.add(asset, {.settings = calmSettings()});
  SimulationSettings restless = calmSettings();
  restless.sleep.enabled = false;
  HairObject& other = run_.add(asset, {.name = "other", .settings = restless});
  fallAsleep(sleeper);
  for (int frame = 0; frame < 20; ++frame) run_.step();
  double largest = 0;
  for (int frame = 1; frame <= 30; ++frame) {
    const AffineTransform bone = shifted(0.05 * (1 - std::cos(0.1 * frame)));
    setBone(sleeper, bone);
    setBone(other, bone);
    run_.step();
    const std::vector<Float4> a = run_.positions(sleeper), b = run_.positions(other);
    keepLargest(largest, maxDistance(a, b));
  }
  EXPECT_EQ(awake(sleeper), 70u);
  // Half a second at less than half a millimetre a second, and what was left to go.
  EXPECT_LT(largest, 1e-3);
}

// A limit that is far too high puts strands to sleep in full swing: what a sleeping tile keeps is
// then seen to the last bit.
TEST_P(ExactScene, WhatSleepsInFullSwingGoesOnAsIfNoTimeHadPassed) {
  const HairAsset asset = wavyAsset(70, 10);
  SimulationSettings settings = calmSettings();
  settings.sleep.enabled = false;
  HairObject& sleeper = run_.add(asset, {.settings = settings});
  const HairObject& other = run_.add(asset, {.name = "other", .settings = settings});
  std::vector<std::vector<Float4>> others;
  size_t steps = 0;
  const auto step = [&] {
    run_.step();
    others.push_back(run_.positions(other));
  };
  // Every remainder of the four states that a strand has.
  for (int pause = 3; pause < 7; ++pause) {
    for (int frame = 0; frame < 3; ++frame, ++steps) step();
    sleeper.settings.sleep = {.enabled = true, .speed = 1e6f, .time = 0};
    while (step(), awake(sleeper) > 0) ++steps;
    for (int frame = 1; frame < pause; ++frame) step();
    EXPECT_EQ(awake(sleeper), 0u);
    EXPECT_EQ(run_.positions(sleeper), others.at(steps - 1));
    sleeper.settings.sleep.enabled = false;
    step();
    ++steps;
    EXPECT_EQ(run_.positions(sleeper), others.at(steps - 1)) << "after " << pause << " frames";
  }
}

TEST_P(ExactScene, OnlyTheTilesThatAColliderStirsWake) {
  // Two tiles, 2 m apart.
  HairAsset asset = wavyAsset(64, 10);
  for (size_t i = size_t{32} * 10; i < asset.positions.size(); ++i) asset.positions[i].x += 2;
  expectOk(asset.process());
  SimulationSettings settings = calmSettings();
  HairObject& hair = run_.add(asset, {.settings = settings});
  CapsuleCollider ball = {
      .head = {2, 1, 0}, .headRadius = 0.05f, .tail = {2, 1, 0}, .tailRadius = 0.05f};
  setCollider(hair, ball);
  fallAsleep(hair);
  ball.head.y = ball.tail.y = 0.3f;
  setCollider(hair, ball);
  run_.step();
  EXPECT_EQ(awake(hair), 32u);
  const std::vector<uint32_t> sleep = run_.read<uint32_t>(hair.buffers().sleep);
  EXPECT_EQ(sleep[0], 1u);
  EXPECT_EQ(sleep[8], 1u) << "groups of find_contacts";
  EXPECT_EQ(sleep[16], 1u) << "the tile that wakes";
}

TEST_P(ExactScene, FollowHairsSleepWithTheirGuides) {
  const HairAsset asset = wavyAsset(20, 8);
  const std::vector<FollowHair> follow = valueOf(asset.generateFollowHairs({.countPerGuide = 3}));
  HairObject& hair = run_.add(
      asset, {.settings = calmSettings(), .followHairs = follow, .storeFollowHairs = true});
  fallAsleep(hair);
  const std::vector<Float4> before = run_.positions(hair);
  for (int frame = 0; frame < 3; ++frame) run_.step();
  EXPECT_EQ(run_.positions(hair), before);
  setBone(hair, shifted(0.1));
  run_.step();
  const std::vector<Float4> moved = run_.positions(hair);
  for (size_t s = 0; s < 80; ++s) EXPECT_NEAR(moved[s * 8].x - before[s * 8].x, 0.1f, 1e-5);
}

TEST_P(ExactScene, FollowHairsLookTheSameWhetherTheyAreStoredOrNot) {
  HairAsset asset = wavyAsset(30, 10);
  asset.strandThickness.resize(30);
  for (uint32_t s = 0; s < 30; ++s) asset.strandThickness[s] = 0.5f + 0.05f * static_cast<float>(s);
  expectOk(asset.process());
  const std::vector<FollowHair> follow = valueOf(asset.generateFollowHairs(
      {.countPerGuide = 6, .guidesPerHair = 3, .maxRadius = 0.02f, .tipSeparation = 2}));
  HairDef def = {.material = {.fiberRadius = 1e-3f}, .followHairs = follow};
  def.settings.tipSeparation = 0.7f;
  HairObject& evaluated = run_.add(asset, def);
  def.storeFollowHairs = true;
  HairObject& stored = run_.add(asset, def);
  for (int frame = 1; frame <= 20; ++frame) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(0.07 * frame, Vector3d(1, 3, 2).normalized()).toRotationMatrix();
    AffineTransform bone;
    for (int i = 0; i < 3; ++i)
      bone.rows[i] = toFloat4(rotation.row(i).transpose(), i == 0 ? 0.1 : 0);
    setBone(evaluated, bone);
    setBone(stored, bone);
    run_.step();
  }
  std::vector<Float4> guides = run_.positions(stored);
  guides.resize(size_t{30} * 10);
  ASSERT_EQ(run_.positions(evaluated), guides);

  const auto render = [&](HairObject& shown) {
    evaluated.visible = &shown == &evaluated;
    stored.visible = &shown == &stored;
    return run_.render({0.1f, 0, 1.6f}, 320);
  };
  const RenderedImage a = render(evaluated), b = render(stored);
  stored.drawnStrands = 30;
  const RenderedImage alone = render(stored);
  const auto off = [](const RenderedImage& one, const RenderedImage& other) {
    size_t count = 0;
    for (size_t i = 0; i < one.pixels.size(); ++i)
      count += distance(one.pixels[i], other.pixels[i]) > 0.01 ||
               std::abs(one.pixels[i].w - other.pixels[i].w) > 0.01f;
    return count;
  };
  EXPECT_GT(off(alone, b), 2000u) << "the follow hairs cannot be seen";
  EXPECT_LE(off(a, b), 5u);
}

TEST_P(ExactScene, LevelOfDetailSimulatesFewerGuidesAndKeepsTheirLengths) {  // K44
  Result<Groom> groom = required(
      generateGroom({.strandCount = 200, .verticesPerStrand = 12, .headCellSize = 0.007f}));
  HairAsset& asset = groom->hair;
  expectOk(asset.process());
  HairObject& hair = run_.add(asset, {.settings = {}, .levelOfDetail = true});
  HairObject& full = run_.add(asset, {.name = "full", .settings = {}});
  hair.simulatedShare = 0.25f;
  double apart = 0;
  const auto placeAt = [](int frame) { return static_cast<float>(0.03 * std::sin(0.1 * frame)); };
  const auto swing = [&](int frame) {
    const AffineTransform bone = shifted(static_cast<double>(placeAt(frame)));
    setBone(hair, bone);
    setBone(full, bone);
    run_.step();
  };
  for (int frame = 0; frame < 40; ++frame) swing(frame);
  EXPECT_EQ(awake(hair), 50u);
  EXPECT_EQ(awake(full), 200u);
  std::vector<Float4> a = run_.positions(hair), b = run_.positions(full);
  double away = 0, moved = 0;
  EXPECT_LT(maxStretch(asset, a), 1e-4);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(isFinite(a[i]));
    keepLargest(apart, distance(a[i], b[i]));
    away += distance(a[i], b[i]);
    Float4 still = asset.positions[i];
    still.x += placeAt(39);
    moved += distance(still, b[i]);
  }
  // Strands of 0.18 m with shapes of their own, which their parents do not have: some end
  // elsewhere, but all in all they are nearer to their own motion than hair that does not move is.
  EXPECT_LT(apart, 0.13);
  EXPECT_LT(away, 0.7 * moved);

  // Back to all of them: over a quarter of a second, without a jump, to the same motion.
  hair.simulatedShare = 1;
  double jump = 0;
  for (int frame = 40; frame < 60; ++frame) {
    swing(frame);
    const std::vector<Float4> now = run_.positions(hair);
    keepLargest(jump, maxDistance(now, a));
    a = now;
  }
  EXPECT_EQ(awake(hair), 200u);
  EXPECT_LT(maxStretch(asset, a), 1e-4);
  EXPECT_LT(jump, 0.04) << "in a frame";
  for (int frame = 60; frame < 240; ++frame) swing(frame);
  a = run_.positions(hair);
  b = run_.positions(full);
  apart = 0;
  keepLargest(apart, maxDistance(a, b));
  EXPECT_LT(apart, 5e-3);
}

TEST_P(ExactScene, AStrandWithTheShapeOfItsParentHasItsMotion) {
  // 40 equal strands: every one that is not simulated moves as if it were.
  const HairAsset asset = strandsAt(40, 10, [](uint32_t s, uint32_t v) {
    const float t = 0.02f * static_cast<float>(v);
    return Float3{0.01f * static_cast<float>(s) + t, -t * t, t * t};
  });
  HairObject& hair = run_.add(asset, {.settings = {}, .levelOfDetail = true});
  hair.simulatedShare = 0.1f;
  for (int frame = 0; frame < 30; ++frame) run_.step();
  const std::vector<Float4> p = run_.positions(hair);
  for (size_t s = 1; s < 40; ++s) {
    for (size_t v = 0; v < 10; ++v) {
      EXPECT_NEAR(p[s * 10 + v].x - p[v].x, 0.01f * static_cast<float>(s), 1e-4);
      EXPECT_NEAR(p[s * 10 + v].y, p[v].y, 1e-4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ExactScene, testing::ValuesIn(kRuntimeApis), apiTestName);

/// On the first API: each takes thousands of frames, and kernels give the same bits on all of them.
class ClassicScene : public SceneTest {};

struct Style {
  const char* name;
  uint32_t vertices;
  double length, radius, frequency;  // of the strand, and of its curls [m, m, 1/m]
};

/// Strands that leave the head in four directions and fall, with curls around the middle line.
HairAsset styledAsset(const Style& style) {
  HairAsset asset;
  asset.strandCount = 4;
  asset.verticesPerStrand = style.vertices;
  const double edge = style.length / (style.vertices - 1);
  for (int s = 0; s < 4; ++s) {
    Vector3d middle(0.2 * s, 0, 0);
    for (uint32_t v = 0; v < style.vertices; ++v) {
      const double along = edge * v, angle = 0.9 - 0.3 * s - 2.0 * along / style.length;
      const Vector3d down(std::cos(angle), std::sin(angle), 0.1 * s);
      if (v > 0) middle += edge * down.normalized();
      const double rotation = 2 * std::numbers::pi * style.frequency * along;
      const double radius = style.radius * std::min(1.0, along / 0.02);
      const Vector3d aside(-std::sin(angle) * std::cos(rotation),
                           std::cos(angle) * std::cos(rotation), std::sin(rotation));
      asset.positions.push_back(toFloat4(middle + radius * aside, v < 2 ? 0 : 1));
    }
  }
  expectOk(asset.process());
  return asset;
}

/// The defaults, weak gravity with a weak pull to the bind pose, and wind.
std::vector<SimulationSettings> classicSettings() {
  SimulationSettings defaults;
  defaults.solver = Solver::kClassic;
  // A breath that moves nothing, as above.
  defaults.airDrag = 1e-4f;
  defaults.wind = {.velocity = {0, 0, 1e-4f}, .gustStrength = 0, .strandVariation = 0};
  SimulationSettings sample = defaults;
  sample.gravity = {0, -2.5f, 0};
  sample.damping = 0.04f;
  sample.vspCoefficient = 0.2f;
  sample.globalStiffness = 0.04f;
  sample.globalRange = 1;
  SimulationSettings windy = defaults;
  windy.airDrag = 2;
  windy.wind = {.velocity = {3, 0, 1}, .gustStrength = 0, .strandVariation = 0};
  return {defaults, sample, windy};
}

// K16
TEST_P(ClassicScene, SettlesInOneShapeAtEveryFrameRate) {
  const Style styles[] = {
      {"straight", 32, 0.34, 0, 0}, {"waves", 24, 0.18, 0.003, 14}, {"curls", 64, 0.24, 0.010, 32}};
  const std::vector<SimulationSettings> all = classicSettings();
  Random random(5);
  const std::pair<const char*, std::function<double(int)>> rates[] = {
      {"60 Hz", [](int) { return 1 / 60.0; }},
      {"15 Hz", [](int) { return 1 / 15.0; }},
      {"30 Hz", [](int) { return 1 / 30.0; }},
      {"144 Hz", [](int) { return 1 / 144.0; }},
      {"240 Hz", [](int) { return 1 / 240.0; }},
      {"30 and 240 Hz", [](int frame) { return frame % 2 == 0 ? 1 / 30.0 : 1 / 240.0; }},
      {"any of 15 to 240 Hz", [&](int) { return random.between(1 / 240.0, 1 / 15.0); }}};
  std::vector<std::vector<Float4>> expected;
  for (const auto& [rate, step] : rates) {
    run_.clear();
    std::vector<std::pair<const HairObject*, std::string>> hairs;
    for (const Style& style : styles) {
      for (size_t k = 0; k < all.size(); ++k) {
        const std::string name = std::string(style.name) + ", settings " + std::to_string(k);
        hairs.emplace_back(&run_.add(styledAsset(style), {.name = name, .settings = all[k]}), name);
      }
    }
    double time = 0;
    for (int frame = 0; time < 6; ++frame) {
      const auto dt = static_cast<float>(step(frame));
      run_.step(dt);
      time += static_cast<double>(dt);
    }
    for (size_t k = 0; k < hairs.size(); ++k) {
      const std::vector<Float4> now = run_.positions(*hairs[k].first);
      if (expected.size() <= k) expected.push_back(now);
      const Style& style = styles[k / all.size()];
      double worst = 0;
      for (size_t i = 0; i < now.size(); ++i) {
        const double off = distance(now[i], expected[k][i]) / style.length;
        worst = std::isfinite(off) ? std::max(worst, off) : INFINITY;
      }
      std::printf("[ FIGURE ] %s at %s: %.3f %% of the length from 60 Hz\n",
                  hairs[k].second.c_str(), rate, 100 * worst);
      EXPECT_LE(worst, 0.001) << hairs[k].second << " at " << rate;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, ClassicScene, testing::Values(kFirstApi), apiTestName);

INSTANTIATE_TEST_SUITE_P(All, SceneSimulation, testing::ValuesIn(solversOnRuntimes()),
                         solverTestName);

}  // namespace
}  // namespace pelage::test
