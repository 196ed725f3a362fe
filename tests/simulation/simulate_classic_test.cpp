// simulate_classic against the double-precision reference, and its invariants.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>

#include "support/not_numbers.h"
#include "support/plain_asset.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

using reference::ClassicReference;
using reference::Pose;

constexpr double kPi = std::numbers::pi;
constexpr double kFloatStep = 1.0f / 60;

Pose moved(const Pose& pose, const Vector3d& shift, const Eigen::AngleAxisd& relativeRotation) {
  return {Eigen::Quaterniond(relativeRotation) * pose.rotation, pose.position + shift};
}

/// Largest distance between what the device has of a strand and the reference [m].
double worstDistance(const std::vector<Float4>& positions, uint32_t strand,
                     const std::vector<Vector3d>& expected) {
  double worst = 0;
  for (size_t v = 0; v < expected.size(); ++v) {
    const Float4& p = positions[strand * expected.size() + v];
    if (!isFinite(p)) return std::numeric_limits<double>::infinity();
    keepLargest(worst, (toVector(p) - expected[v]).norm());
  }
  return worst;
}

/// Largest |length - rest length| / (rest length + rounding of coordinates) over segments from 1.
double worstStretch(const HairAsset& asset, const std::vector<Float4>& positions) {
  double worst = 0;
  const uint32_t n = asset.verticesPerStrand;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    for (uint32_t v = 1; v + 1 < n; ++v) {
      const Vector3d a = toVector(positions[s * n + v]), b = toVector(positions[s * n + v + 1]);
      const double rest = asset.restLengths[s * n + v];
      const double length = (b - a).norm();
      if (!std::isfinite(length)) return std::numeric_limits<double>::infinity();
      const double rounding = 4e-7 * (a.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff());
      keepLargest(worst, std::max(std::abs(length - rest) - rounding, 0.0) / std::max(rest, 1e-12));
    }
  }
  return worst;
}

/// A head that shakes and turns; step 0 is the bind pose.
Pose headPose(const Pose& bind, int step, double violence = 1) {
  const double t = step * kFloatStep;
  const Eigen::AngleAxisd relativeRotation(violence * 0.6 * std::sin(7 * t),
                                           Vector3d(0.2, 1, 0.3).normalized());
  const Vector3d neck(0, -0.3, 0);
  Pose pose;
  pose.rotation = Eigen::Quaterniond(relativeRotation);
  pose.position = neck + relativeRotation * (bind.position - neck) +
                  violence * Vector3d(0.05 * std::sin(9 * t), 0.02 * std::sin(5 * t), 0);
  return pose;
}

std::vector<Pose> headPoses(const HairAsset& asset, int step, double violence = 1) {
  std::vector<Pose> poses;
  for (uint32_t s = 0; s < asset.strandCount; ++s)
    poses.push_back(headPose(bindPose(asset, s), step, violence));
  return poses;
}

/// The vertices of the bind pose after the motion of the root.
std::vector<Vector3d> targetsOf(const HairAsset& asset, uint32_t strand, const Pose& root) {
  const ClassicReference rest(bindOf(asset, strand));
  std::vector<Vector3d> targets;
  for (int v = 0; v < rest.count(); ++v) targets.push_back(rest.target(root, v));
  return targets;
}

/// Constants that make every term count.
void setLively(SimulationConstants& c) {
  c.gravity = {0.5f, -9.81f, 0.3f, 0};
  c.wind = {3, 0.5f, -2, 4};
  c.dampingKeep = 0.94f;
  c.localStiffness = 0.6f;
  c.globalStiffness = 0.05f;
  c.globalRange = 0.5f;
  c.vspCoefficient = 0.5f;
  c.vspThreshold = 30;
}

/// Hair in its bind pose on which every term acts.
struct LivelyRun : StrandRun {
  LivelyRun(Gpu& gpu, const HairAsset& asset) : StrandRun(gpu, asset) {
    reset(bindPoses(asset));
    setLively(constants);
  }
};

class SimulateClassic : public GpuTest {
 protected:
  /// Steps 1 to `last` of the head.
  static void shake(StrandRun& run, const HairAsset& asset, const StrandTerms& terms, int last,
                    double violence = 1) {
    for (int step = 1; step <= last; ++step) {
      run.setRoots(headPoses(asset, step, violence), headPoses(asset, step - 1, violence));
      run.simulate(terms);
      run.run();
    }
  }
};

/// On the first API: ApiAgreement compares the others with it, and these take seconds.
class SimulateClassicOnce : public SimulateClassic {};

TEST_P(SimulateClassic, MatchesTheReferenceWithAnyOfItsTerms) {
  const HairAsset asset = wavyAsset(5, 12);
  // The sanitizers see nothing of the arithmetic in the kernels.
  const int steps = kSanitized ? 2 : 8;
  for (uint32_t mask = 0; mask < 16; ++mask) {
    const StrandTerms terms = StrandRun::terms(mask & 1, mask & 2, mask & 4, mask & 8);
    SCOPED_TRACE(mask);
    LivelyRun run(gpu(), asset);
    std::vector<ClassicReference> references;
    for (uint32_t s = 0; s < asset.strandCount; ++s) references.emplace_back(bindOf(asset, s));
    for (int step = 1; step <= steps; ++step) {
      // Two sub-steps of different length a frame.
      run.setRoots(headPoses(asset, step), headPoses(asset, step - 1));
      const float shares[3] = {0, 0.4f, 1};
      for (int part = 0; part < 2; ++part) {
        SimulationConstants& c = run.constants;
        c.rootBegin = shares[part];
        c.rootEnd = shares[part + 1];
        const float stepBefore = c.timeStep;
        c.timeStep = (c.rootEnd - c.rootBegin) / 60;
        c.timeStepRatio = c.timeStep / stepBefore;
        c.forceShare = c.timeStep * c.timeStep * 3600;
        run.simulate(terms);
        for (uint32_t s = 0; s < asset.strandCount; ++s) {
          const Pose bind = bindPose(asset, s);
          const Pose last = headPose(bind, step - 1), now = headPose(bind, step);
          references[s].step(toStep(c, terms), reference::interpolate(last, now, c.rootBegin),
                             reference::interpolate(last, now, c.rootEnd));
        }
      }
      run.run();
    }
    const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      // 16 sub-steps of float arithmetic; a wrong term is off by a millimetre or more.
      EXPECT_LT(worstDistance(positions, s, references[s].current), 2e-5) << "strand " << s;
      EXPECT_LT(worstDistance(tangents, s, references[s].tangents()), 2e-3) << "strand " << s;
      EXPECT_GT((references[s].current.back() -
                 references[s].target(headPose(bindPose(asset, s), steps), 11))
                    .norm(),
                1e-3)
          << "nothing moved: the comparison would not see anything";
    }
    run.checkGuards();
  }
}

struct Size {
  uint32_t strands, vertices;
};

// K1, K8
TEST_P(SimulateClassicOnce, TakesAnyNumberOfStrandsAndVertices) {
  for (const Size size : {Size{1, 2}, Size{1, 3}, Size{63, 5}, Size{64, 17}, Size{65, 33},
                          Size{3, 256}, Size{65537, 3}}) {
    SCOPED_TRACE(size.strands);
    SCOPED_TRACE(size.vertices);
    const HairAsset asset = wavyAsset(size.strands, size.vertices, 3);
    LivelyRun run(gpu(), asset);
    const StrandTerms terms = StrandRun::terms(true, true, true, true);
    shake(run, asset, terms, 2);
    const std::vector<Float4> positions = run.positions();
    for (uint32_t s = 0; s < size.strands; s += std::max(1u, size.strands / 61)) {
      ClassicReference expected(bindOf(asset, s));
      for (int step = 1; step <= 2; ++step) {
        const Pose bind = bindPose(asset, s);
        expected.step(toStep(run.constants, terms), headPose(bind, step - 1), headPose(bind, step));
      }
      // A vertex of 256 may be pushed by the weight of all others, 600 times its segment's length:
      // what it is off the line is multiplied by that, and so is rounding.
      EXPECT_LT(worstDistance(positions, s, expected.current), size.vertices > 64 ? 2e-3 : 2e-5)
          << "strand " << s;
    }
    EXPECT_LT(worstStretch(asset, positions), 1e-5);
    run.checkGuards();
  }
}

// K2, K9: nothing depends on which threads run beside a strand's.
TEST_P(SimulateClassic, GivesAStrandTheSameBitsAloneAndAmongOthers) {
  const HairAsset all = wavyAsset(131, 19, 3);
  const auto simulated = [&](const HairAsset& asset) {
    LivelyRun run(gpu(), asset);
    run.setColliders(
        {{{0, -0.1f, 0, 0.1f}, {0, -0.1f, 0, 0.1f}, {0, -0.1f, 0, 0.3f}, {0, -0.1f, 0, 0}, {}}});
    shake(run, asset, StrandRun::terms(true, true, true, true, true), 5);
    return run.positions();
  };
  const std::vector<Float4> among = simulated(all);
  for (const uint32_t s : {0u, 31u, 63u, 64u, 130u}) {
    HairAsset one;
    one.strandCount = 1;
    one.verticesPerStrand = 19;
    one.positions.assign(all.positions.begin() + s * 19, all.positions.begin() + (s + 1) * 19);
    expectOk(one.process());
    const std::vector<Float4> alone = simulated(one);
    EXPECT_EQ(std::memcmp(alone.data(), among.data() + s * 19, 19 * sizeof(Float4)), 0) << s;
  }
}

// K13
TEST_P(SimulateClassicOnce, KeepsItsShapeWhileTheRootTurnsRoundAndRound) {
  const HairAsset asset = wavyAsset(8, 16, 4);
  StrandRun run(gpu(), asset);
  std::vector<Pose> last = bindPoses(asset);
  run.reset(last);
  run.constants.localStiffness = 0.9f;
  run.constants.localIterations = 16;
  run.constants.dampingKeep = 0.5f;
  const Vector3d axis = Vector3d(1, 2, -2) / 3;
  double worst = 0;
  // 0.25 degrees a step, twice around: every direction relative to the bind pose is passed.
  for (int step = 0; step < 2880; ++step) {
    std::vector<Pose> now = last;
    for (Pose& pose : now)
      pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(kPi / 720, axis)) * pose.rotation;
    run.setRoots(now, last);
    run.simulate(StrandRun::terms(false, false, true));
    run.run();
    last = now;
    if (step < 200 || step % 24 != 0) continue;
    const std::vector<Float4> positions = run.positions();
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      const std::vector<Vector3d> targets = targetsOf(asset, s, now[s]);
      keepLargest(worst, worstDistance(positions, s, targets));
    }
  }
  // It lags behind by a share of its 0.3 m; a flip would be as large as the strand.
  EXPECT_LT(worst, 0.05);
}

// K4
TEST_P(SimulateClassicOnce, KeepsTheRestPoseWithoutGravity) {
  // Everything from nearly straight to tight curls, and a pose away from the bind pose.
  const HairAsset asset = wavyAsset(40, 32, 7);
  const std::vector<Pose> poses = headPoses(asset, 11);
  for (const bool localShape : {false, true}) {
    StrandRun run(gpu(), asset);
    run.reset(poses);
    run.constants.dampingKeep = 0.94f;
    run.constants.localStiffness = 0.9f;
    run.constants.vspCoefficient = 0.7f;
    run.constants.vspThreshold = 30;
    run.constants.wind.w = 2;
    for (int step = 0; step < 600; ++step)
      run.simulate(StrandRun::terms(true, false, localShape, true));
    run.run();
    const std::vector<Float4> positions = run.positions();
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      const std::vector<Vector3d> targets = targetsOf(asset, s, poses[s]);
      // The rounding of the goal's own coordinates; what wanders does not stay within it.
      EXPECT_LT(worstDistance(positions, s, targets), 2e-7)
          << "strand " << s << ", local shape " << localShape;
    }
  }
}

// K5
TEST_P(SimulateClassic, KeepsLengthsUnderAViolentRootMotion) {
  const HairAsset asset = wavyAsset(65, 32, 5);
  LivelyRun run(gpu(), asset);
  std::vector<Pose> last = bindPoses(asset);
  Random random(9);
  for (int step = 0; step < 30; ++step) {
    std::vector<Pose> now = last;
    for (Pose& pose : now)
      pose = moved(pose, random.vector(0.3),
                   Eigen::AngleAxisd(random.between(-2, 2), random.vector(1).normalized()));
    run.setRoots(now, last);
    run.simulate(StrandRun::terms(true, true, true, false));
    run.run();
    // Beyond the rounding of the coordinates; the aim is one tenth of a percent.
    EXPECT_LT(worstStretch(asset, run.positions()), 1e-5) << "step " << step;
    last = now;
  }
}

TEST_P(SimulateClassic, HoldsAVertexInTheMiddleAndAtTheTip) {
  const HairAsset asset = wavyAsset(20, 24, 4, {12, 23});
  LivelyRun run(gpu(), asset);
  shake(run, asset, StrandRun::terms(true, false, true, true), 60);
  const std::vector<Float4> positions = run.positions();
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const ClassicReference rest(bindOf(asset, s), {12, 23});
    const Pose pose = headPose(bindPose(asset, s), 60);
    for (const int v : {0, 1, 12, 23}) {
      EXPECT_LT(
          (toVector(positions[s * 24 + static_cast<uint32_t>(v)]) - rest.target(pose, v)).norm(),
          1e-6)
          << "strand " << s << " vertex " << v;
    }
  }
  // Spans that are nearly taut keep a little error, spread over their segments.
  EXPECT_LT(worstStretch(asset, positions), 0.005);
}

TEST_P(SimulateClassic, StretchesASpanEvenlyThatIsTooShortForItsEnds) {
  HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = 12;
  for (int v = 0; v < 12; ++v)
    asset.positions.push_back(
        {0.01f * static_cast<float>(v), 0, 0, v < 2 || v == 11 ? 0.0f : 1.0f});
  expectOk(asset.process());
  // The rest lengths are those of half the size.
  for (float& length : asset.restLengths) length *= 0.5f;
  StrandRun run(gpu(), asset);
  run.reset(bindPoses(asset));
  run.constants.gravity = {0, -9.81f, 0, 0};
  for (int step = 0; step < 20; ++step) run.simulate(StrandRun::terms());
  run.run();
  const std::vector<Float4> positions = run.positions();
  for (uint32_t v = 2; v < 12; ++v)
    EXPECT_NEAR(positions[v].x - positions[v - 1].x, 0.01f, 1e-6f) << "vertex " << v;
}

// K18
TEST_P(SimulateClassic, ResetTakesTheGoalAndForgetsVelocities) {
  const HairAsset asset = wavyAsset(7, 16);
  LivelyRun run(gpu(), asset);
  shake(run, asset, StrandRun::terms(true, true, true, true), 20);
  const std::vector<Pose> poses = headPoses(asset, 50, 3);
  run.reset(poses);
  const auto check = [&](double tolerance) {
    const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      const std::vector<Vector3d> targets = targetsOf(asset, s, poses[s]);
      EXPECT_LT(worstDistance(positions, s, targets), tolerance);
      const Vector3d tip = (targets[15] - targets[14]).normalized();
      EXPECT_LT((toVector(tangents[s * 16 + 15]) - tip).norm(), 1e-4);
    }
  };
  check(1e-6);
  run.constants.gravity = {0, 0, 0, 0};
  run.simulate(StrandRun::terms(false, false, true, true));
  run.run();
  // A velocity that was kept would show as centimetres here.
  check(2e-6);
}

TEST_P(SimulateClassic, PutsVerticesThatAreNotNumbersAtTheirGoalAndRecovers) {
  const HairAsset asset = wavyAsset(6, 16);
  StrandRun run(gpu(), asset);
  const std::vector<Pose> poses = bindPoses(asset);
  run.reset(poses);
  setLively(run.constants);
  std::vector<Float4> state = run.state();
  const size_t half = state.size() / 2;
  const auto at = [&](size_t set, uint32_t vertex, uint32_t strand) -> Float4& {
    return state[set * half + vertex * 6 + strand];
  };
  at(0, 5, 0).x = kNan;
  for (uint32_t v = 0; v < 16; ++v) at(0, v, 1) = {kNan, kNan, kNan, kNan};
  at(1, 7, 2).y = kInf;
  at(0, 15, 3).z = -kInf;
  at(0, 9, 4).x = 3e38f;
  at(1, 0, 5).z = kNan;
  run.setState(state);
  run.simulate(StrandRun::terms(true, true, true, true));
  run.run();
  EXPECT_LT(worstStretch(asset, run.positions()), 1e-5);
  for (const Float4& p : run.state()) ASSERT_TRUE(isFinite(p));
  for (const Float4& t : run.tangents()) ASSERT_NEAR(toVector(t).norm(), 1, 1e-5);
  // Not far from where a strand is that never was lost.
  const std::vector<Float4> positions = run.positions();
  for (uint32_t s = 0; s < 6; ++s)
    EXPECT_LT((toVector(positions[s * 16 + 15]) - bindOf(asset, s)[15]).norm(), 0.1);
}

TEST_P(SimulateClassic, TakesTheGoalWhereOnlyTheHistoryIsLost) {
  const HairAsset asset = wavyAsset(1, 12);
  StrandRun run(gpu(), asset);
  run.reset(bindPoses(asset));
  std::vector<Float4> state = run.state();
  for (size_t v = 2; v < 12; ++v) {
    state[v].x += 0.05f;
    state[12 + v].y = kNan;
  }
  run.setState(state);
  run.simulate(StrandRun::terms(false, false, true, true));
  run.run();
  EXPECT_LT(worstDistance(run.positions(), 0, bindOf(asset, 0)), 1e-6);
}

TEST_P(SimulateClassic, StandsRootTransformsThatNobodyWrote) {
  const HairAsset asset = wavyAsset(2, 8);
  StrandRun run(gpu(), asset);
  run.setRootTransforms({RootTransform{},
                         {{kNan, 0, 0, 1}, {0, 0, 0, 0}},
                         RootTransform{},
                         {{0, 0, 0, 1}, {kNan, 0, 0, 0}}});
  run.constants.flags = 1;
  run.simulate(StrandRun::terms(true, true, true, true));
  run.run();
  const std::vector<Float4> positions = run.positions();
  for (uint32_t s = 0; s < 2; ++s) EXPECT_LT(worstDistance(positions, s, bindOf(asset, s)), 1e-6);
}

// K17
TEST_P(SimulateClassicOnce, MakesNoNanFromAnythingFinite) {
  Random random(21);
  HairAsset asset;
  asset.strandCount = 400;
  asset.verticesPerStrand = 16;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    Vector3d p = random.vector(1);
    Vector3d direction = random.vector(1).normalized();
    const double size = std::pow(10.0, random.between(-9, 0.5));
    for (uint32_t v = 0; v < 16; ++v) {
      asset.positions.push_back(toFloat4(p, random.unit() < 0.03 || v < 2 ? 0 : 1));
      const double kind = random.unit();
      if (kind < 0.15) continue;  // coincident
      if (kind < 0.25)
        direction = -direction;  // folded
      else if (s % 3 == 0)
        direction = (direction + random.vector(0.8)).normalized();
      p += direction * size * (s % 2 == 0 ? 1 : random.between(0.01, 1));
      if (s % 50 == 0) p = toVector(asset.positions.back());  // all in one point
    }
  }
  expectOk(asset.process());
  StrandRun run(gpu(), asset);
  std::vector<Pose> last = bindPoses(asset);
  run.reset(last);
  SimulationConstants& c = run.constants;
  for (int step = 0; step < 90; ++step) {
    setLively(c);
    const float stepBefore = c.timeStep;
    c.timeStep = static_cast<float>(random.between(1.0 / 240, 1.0 / 15));
    c.timeStepRatio = c.timeStep / stepBefore;
    c.forceShare = std::min(c.timeStep * c.timeStep * 3600, 1.0f);
    c.gravityStep = std::max(c.timeStep, 1.0f / 60) / 60;
    c.gravity = toFloat4(random.vector(std::pow(10.0, random.between(0, 6))));
    c.wind = toFloat4(random.vector(std::pow(10.0, random.between(0, 4))), random.between(0, 1e6));
    c.localStiffness = static_cast<float>(random.between(0, 0.99));
    c.maxSpeed = static_cast<float>(std::pow(10.0, random.between(-3, 30)));
    std::vector<Pose> now = last;
    for (Pose& pose : now)
      pose = moved(pose, random.vector(step % 10 == 0 ? 5 : 0.1),
                   Eigen::AngleAxisd(random.between(-kPi, kPi), random.vector(1).normalized()));
    run.setRoots(now, last);
    run.simulate(
        StrandRun::terms(step % 2 == 0, true, step % 2 == 0 || step % 5 != 0, step % 3 != 0));
    run.run();
    const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
    for (size_t i = 0; i < positions.size(); ++i) {
      ASSERT_TRUE(isFinite(positions[i])) << "step " << step << " vertex " << i;
      ASSERT_NEAR(toVector(tangents[i]).norm(), 1, 1e-5) << "step " << step << " vertex " << i;
      ASSERT_LT(toVector(positions[i]).norm(), 1e4) << "step " << step << " vertex " << i;
    }
    for (Pose& pose : now) pose.position = pose.position.cwiseMax(-20.0).cwiseMin(20.0);
    last = now;
  }
  run.checkGuards();
}

// K4, K5: a groom of 2228 strands with segments of very different length, some below a micrometre.
TEST_P(SimulateClassicOnce, KeepsTheMohawkAtRestAndItsLengthsInMotion) {
  const std::filesystem::path path =
      std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy" / "Ratboy_mohawk.tfx";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Result<HairAsset> asset = required(loadTfx(path));
  expectOk(asset->process());
  StrandRun run(gpu(), *asset);
  const std::vector<Pose> bind = bindPoses(*asset);
  run.reset(bind);
  const std::vector<Float4> before = run.positions();
  setLively(run.constants);
  const Float4 gravity = run.constants.gravity;
  run.constants.gravity = {};
  run.constants.wind = {0, 0, 0, 2};
  const StrandTerms terms = StrandRun::terms(true, true, true, true);
  for (int step = 0; step < 60; ++step) run.simulate(terms);
  run.run();
  const std::vector<Float4> after = run.positions();
  double drift = 0, size = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    keepLargest(drift, (toVector(after[i]) - toVector(before[i])).norm());
    keepLargest(size, toVector(before[i]).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
  }
  EXPECT_LT(drift, 2e-6 * size);

  run.constants.gravity = gravity;
  shake(run, *asset, terms, 60, 2);
  EXPECT_LT(worstStretch(*asset, run.positions()), 1e-3);
  run.checkGuards();
}

/// One strand along `direction`, root at the origin.
HairAsset straightAsset(uint32_t vertices, double length, const Vector3d& direction) {
  return strandsAt(1, vertices, [&](uint32_t, uint32_t v) {
    return toFloat3(direction * (length * v / (vertices - 1)));
  });
}

// K15
TEST_P(SimulateClassic, BlowsEveryVertexAlikeForShortAndLongSegments) {
  // Free motion only: no length solve can be switched off, so one step, before the strand bends.
  for (const uint32_t vertices : {4u, 16u, 64u}) {
    const HairAsset asset = straightAsset(vertices, 0.3, {0, -1, 0});
    StrandRun run(gpu(), asset);
    run.reset(bindPoses(asset));
    run.constants.wind = {0.01f, 0, 0, 3};
    run.simulate(StrandRun::terms(true));
    run.run();
    const std::vector<Float4> positions = run.positions();
    // c h / (1 + c h) h w
    const double expected = 0.05 / 1.05 * 0.01 / 60;
    for (uint32_t v = 2; v < vertices; ++v)
      EXPECT_NEAR(positions[v].x, expected, 0.02 * expected)
          << "vertex " << v << " of " << vertices;
  }
}

// K15
TEST_P(SimulateClassic, ReachesTheSpeedOfTheAirWhateverTheDrag) {
  for (const float drag : {1.0f, 1e3f, 1e7f}) {
    const HairAsset asset = straightAsset(3, 1000, {0, -1, 0});
    StrandRun run(gpu(), asset);
    run.reset(bindPoses(asset));
    run.constants.wind = {2, 0, 0, drag};
    run.constants.lengthIterations = 0;
    for (int step = 0; step < 600; ++step) run.simulate(StrandRun::terms(true));
    run.run();
    const std::vector<Float4> state = run.state();
    // The last vertex hangs on 500 m: it moves freely, up to the speed of the air.
    const double speed = (static_cast<double>(state[2].x) - static_cast<double>(state[5].x)) * 60;
    EXPECT_NEAR(speed, 2, 0.01) << "drag " << drag;
  }
}

// K7
TEST_P(SimulateClassic, LimitsTheSpeedToItsSetting) {
  const HairAsset asset = straightAsset(3, 1000, {0, -1, 0});
  for (const float speed : {10.0f, 39.0f, 41.0f, 200.0f, 5000.0f}) {
    StrandRun run(gpu(), asset);
    run.reset(bindPoses(asset));
    std::vector<Float4> state = run.state();
    state[5].x = -speed / 60;
    run.setState(state);
    run.constants.maxSpeed = 40;
    run.simulate(StrandRun::terms());
    run.run();
    const double expected = static_cast<double>(std::min(speed, 40.0f)) / 60;
    EXPECT_NEAR(run.positions()[2].x, expected, 1e-5 * expected) << "at " << speed << " m/s";
  }
}

// K12
TEST_P(SimulateClassic, TakesPartInTheRootsMotionWithoutASwitch) {
  const HairAsset asset = straightAsset(8, 0.3, {1, 0, 0});
  // Root accelerations around the threshold, in metres per second squared.
  const auto tipAfter = [&](double acceleration) {
    StrandRun run(gpu(), asset);
    const std::vector<Pose> last = bindPoses(asset);
    run.reset(last);
    run.constants.vspCoefficient = 0.2f;
    run.constants.vspThreshold = 50;
    run.constants.lengthIterations = 0;
    std::vector<Pose> now = last;
    now[0].position.y() += acceleration / 3600;
    run.setRoots(now, last);
    run.simulate(StrandRun::terms(false, false, false, true));
    run.run();
    return (toVector(run.positions()[7]) - toVector(asset.positions[7])).y() * 3600 / acceleration;
  };
  double before = tipAfter(10);
  EXPECT_LT(before, 0.75);
  for (double acceleration = 20; acceleration <= 140; acceleration += 5) {
    const double share = tipAfter(acceleration);
    EXPECT_GE(share, before - 2e-3) << acceleration;
    EXPECT_LT(share - before, 0.2) << "a switch at " << acceleration;
    before = share;
  }
  EXPECT_NEAR(before, 1, 1e-4);
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Apis, SimulateClassic, testing::ValuesIn(kApis), apiTestName);
INSTANTIATE_TEST_SUITE_P(Apis, SimulateClassicOnce, testing::Values(kFirstApi), apiTestName);

}  // namespace pelage::test
