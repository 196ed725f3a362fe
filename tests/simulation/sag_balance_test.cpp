// Rest shapes that gravity bends into the bind shape, against the reference of the rod.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "../reference/rod/exact_rod.h"
#include "pelage/sag_compensation.h"
#include "simulation/exact_solver.h"
#include "simulation/sag_balance.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using detail::SagJoint;
using detail::SagLoad;
using rod::ExactRod;
using rod::Quaterniond;
using rod::RestStrand;
using rod::RodSettings;
using rod::RootPose;
using rod::Vector3d;

constexpr double kTwistRatio = 0.75, kDamping = 0.06;

// Distributions of the standard library differ from one implementation to the next.
class SagRandom {
 public:
  explicit SagRandom(uint32_t seed) : engine_(seed) {}
  double between(double a, double b) {
    return a + (b - a) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  Vector3d cube() {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return {x, y, z};
  }

 private:
  std::mt19937 engine_;
};

/// Straight, curled and evenly bent strands of 8 to 48 vertices in all directions.
std::vector<Vector3d> randomStrand(SagRandom& random, int kind) {
  const int n = 8 + static_cast<int>(random.between(0, 40));
  const double size = random.between(0.05, 0.4);
  const Vector3d direction = rod::directionOr(random.cube(), Vector3d(1, 0, 0));
  if (kind == 0) return rod::straightPoints(n, size, direction);
  if (kind == 1) {
    const double turns = random.between(0.5, 4), radius = random.between(0.004, 0.015);
    std::vector<Vector3d> points = rod::helixPoints(n, radius, size / turns, turns);
    const Quaterniond tilt = rod::rotationBetween(Vector3d(0, -1, 0), direction);
    for (Vector3d& p : points) p = rod::rotate(tilt, p);
    return points;
  }
  const Vector3d axis = random.cube();
  const double bend = random.between(0, 10) * size / (n - 1);
  std::vector<Vector3d> points;
  Vector3d p, edge = direction;
  for (int i = 0; i < n; ++i) {
    points.push_back(p);
    p += edge * (size / (n - 1));
    edge = rod::directionOr(edge + rod::cross(axis, edge) * bend, edge);
  }
  return points;
}

detail::Vector3<double> own(const Vector3d& v) { return {v.x, v.y, v.z}; }
detail::UnitQuaternion<double> own(const Quaterniond& q) { return {q.x, q.y, q.z, q.w}; }
Quaterniond referenceOf(const detail::UnitQuaternion<double>& q) { return {q.x, q.y, q.z, q.w}; }

/// A strand of the reference, as the balance takes it.
struct SagStrand {
  RestStrand strand;
  RodSettings settings;
  std::vector<detail::Vector3<double>> tangents;
  std::vector<double> springs;
  std::vector<SagJoint> joints;

  SagStrand(std::vector<Vector3d> points, double bendLength) : strand(std::move(points)) {
    const double bend = 9.81 * std::pow(bendLength, 3);
    settings.material = {bend, kTwistRatio * bend, -60 * std::log(1 - kDamping), 0};
    for (const Quaterniond& frame : strand.frames) tangents.push_back(own(rod::axisX(frame)));
    joints.resize(strand.frames.size());
  }
  void setGlobalShape(double stiffness, double range) {
    settings.globalStiffness = stiffness;
    settings.globalRange = range;
    springs.clear();
    for (const double share : strand.share) {
      const double within = std::clamp((1.25 * range - share) / (0.25 * range), 0.0, 1.0);
      springs.push_back(within * stiffness * 3600 / (1 - stiffness));
    }
  }
  SagLoad load(double share = 1) const {
    return {.acceleration = own(settings.gravity * share),
            .bend = settings.material.bend,
            .twist = settings.material.twist};
  }
  detail::BoundRod bound() const {
    return {.rootFrame = own(strand.frames[0]),
            .tangents = tangents,
            .lengths = strand.lengths,
            .voronoiLengths = strand.voronoiLengths,
            .stiffness = strand.stiffness,
            .springs = springs};
  }
  bool carries(double share) {
    return detail::balanceJoints(bound(), load(share), joints) &&
           detail::isStable(bound(), load(share), joints);
  }
  double balance() { return detail::balanceSag(bound(), load(), joints); }
  RestStrand balanced() const {
    RestStrand rest = strand;
    rest.joints = rest.relative;
    for (size_t i = 1; i < joints.size(); ++i) {
      rest.joints[i] = referenceOf(joints[i].rest);
      rest.relative[i] = referenceOf(joints[i].bind);
    }
    return rest;
  }
  /// The farthest that a vertex is from its bind position [m].
  /// \param always  in any frame, or only at the end
  template <class Real>
  double distanceAfter(double seconds, double jerk, bool always) const {
    const RestStrand rest = balanced();
    ExactRod<Real> simulated(rest, {});
    double farthest = 0;
    const int frames = static_cast<int>(seconds * 60);
    for (int frame = 1; frame <= frames; ++frame) {
      RootPose pose;
      if (frame <= 10)
        pose.rotation = rod::axisAngle(rod::directionOr(Vector3d(0.3, 0.5, 0.8), {}),
                                       jerk * std::sin(std::numbers::pi * frame / 10));
      simulated.step(1 / 60.0, pose, settings);
      if (!always && frame < frames) continue;
      for (int i = 0; i < rest.size(); ++i)
        test::keepLargest(farthest,
                          rod::length(Vector3d(simulated.position(i)) - rest.positions[i]));
    }
    return farthest;
  }
};

double randomBendLength(SagRandom& random) {
  return std::exp(random.between(std::log(0.03), std::log(0.3)));
}

TEST(SagBalance, StrandsStayInTheirBindShape) {
  SagRandom random(1);
  double inDouble = 0, inFloat = 0;
  int strands = 0;
  for (int k = 0; k < 40; ++k) {
    SagStrand sag(randomStrand(random, k % 3), randomBendLength(random));
    // Factors along the strand, as curves.stiffness.
    for (double& factor : sag.strand.stiffness) factor = k % 2 == 0 ? 1 : random.between(0.5, 2);
    if (sag.balance() < 1) continue;
    ++strands;
    test::keepLargest(inDouble, sag.distanceAfter<double>(10, 0, true));
    test::keepLargest(inFloat, sag.distanceAfter<float>(10, 0, true));
  }
  printf("    %d strands in 10 s [m]: double %.2g, float %.2g\n", strands, inDouble, inFloat);
  EXPECT_GT(strands, 15);
  EXPECT_LT(inDouble, 1e-10);
  EXPECT_LT(inFloat, 1e-5);
}

TEST(SagBalance, KnowsWhichStrandsFall) {
  SagRandom random(2);
  int stay = 0, fall = 0;
  double staying = 0, falling = std::numeric_limits<double>::max();
  for (int k = 0; k < 40; ++k) {
    SagStrand sag(randomStrand(random, k % 3), randomBendLength(random));
    if (k % 4 == 3) sag.setGlobalShape(0.05, 0.4);
    const double share = sag.balance();
    if (share == 1) {
      // Close to the limit strands take minutes to come back.
      if (!sag.carries(1.1)) continue;
      sag.balance();
      ++stay;
      test::keepLargest(staying, sag.distanceAfter<float>(10, 0.05, false));
    } else if (share < 0.9 && detail::balanceJoints(sag.bound(), sag.load(), sag.joints)) {
      ++fall;
      test::keepSmallest(falling, sag.distanceAfter<float>(10, 0.05, false));
    }
  }
  printf("    10 s after a jerk [m]: %d stable strands at most %.2g, %d others at least %.2g\n",
         stay, staying, fall, falling);
  EXPECT_GT(stay, 10);
  EXPECT_GT(fall, 7);
  EXPECT_LT(staying, 5e-4);
  EXPECT_GT(falling, 0.01);
}

TEST(SagBalance, TakesTheLargestShareThatIsStable) {
  SagRandom random(3);
  int limp = 0;
  for (int k = 0; k < 60; ++k) {
    SagStrand sag(randomStrand(random, k % 3), 0.03);
    const double share = sag.balance();
    if (share == 1) continue;
    ++limp;
    EXPECT_GT(share, 0);
    const std::vector<SagJoint> joints = sag.joints;
    EXPECT_TRUE(sag.carries(share));
    for (size_t i = 1; i < joints.size(); ++i) EXPECT_EQ(joints[i].rest.y, sag.joints[i].rest.y);
    EXPECT_FALSE(sag.carries(share + 2.0 / 4096));
  }
  EXPECT_GT(limp, 30);
}

// A column of the length L buckles at L^3 = 7.837 B / g (Greenhill, 1881).
TEST(SagBalance, FindsTheHeightAtWhichColumnsBuckle) {
  const auto stands = [](double size) {
    SagStrand sag(rod::straightPoints(128, size, Vector3d(0, 1, 0)), 0.05);
    return sag.balance() == 1;
  };
  double low = 0.01, high = 1;
  for (int i = 0; i < 30; ++i) (stands(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  const double expected = 0.05 * std::cbrt(7.837 / 1.01);
  printf("    %.5f m, expected %.5f m\n", low, expected);
  // Edge 0 is clamped, and the root's joint has its compliance.
  EXPECT_NEAR(low, expected, 0.01 * expected);
}

// Strands that hang straight down balance any weight.
TEST(SagBalance, HangingStrandsNeedNoStiffness) {
  SagStrand sag(rod::straightPoints(32, 0.5, Vector3d(0, -1, 0)), 0.001);
  EXPECT_EQ(sag.balance(), 1);
  for (size_t i = 1; i < sag.joints.size(); ++i) EXPECT_EQ(std::abs(sag.joints[i].rest.w), 1);
}

TEST(SagBalance, SurvivesAnyStrand) {
  const std::vector<std::vector<Vector3d>> strands = {
      {Vector3d(), Vector3d(0.1, 0, 0)},
      std::vector<Vector3d>(6),
      {Vector3d(), Vector3d(0.1, 0, 0), Vector3d(), Vector3d(0.1, 0, 0), Vector3d()},
      {Vector3d(), Vector3d(1e-6, 0, 0), Vector3d(3, 0, 0), Vector3d(3, 1e-5, 0)},
      {Vector3d(), Vector3d(), Vector3d(0.1, 0, 0), Vector3d(0.1, 0, 0), Vector3d(0.1, 0.1, 0)}};
  for (const auto& points : strands) {
    for (const double bendLength : {0.0, 1e-6, 0.05, 10.0}) {
      for (const double gravity : {1e-30, 9.81, 1e6, 3e38}) {
        SagStrand sag(points, bendLength);
        sag.settings.gravity = Vector3d(0, -gravity, 0.3 * gravity);
        const double share = sag.balance();
        EXPECT_TRUE(share >= 0 && share <= 1);
        for (size_t i = 1; i < sag.joints.size(); ++i) {
          const SagJoint& joint = sag.joints[i];
          for (const auto& q : {joint.rest, joint.bind})
            EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-9);
          EXPECT_EQ(joint.rest.x, 0);
        }
      }
    }
  }
}

TEST(SagReach, NamesGuidesThatAreTooLimp) {
  // The first strand points to the side, the second one down.
  HairAsset asset;
  asset.strandCount = 2;
  asset.verticesPerStrand = 24;
  for (const Float3 direction : {Float3{1, 0, 0}, Float3{0, -1, 0}})
    for (uint32_t i = 0; i < 24; ++i) {
      const float at = 0.01f * static_cast<float>(i);
      asset.positions.push_back({direction.x * at, direction.y * at, direction.z * at, 1});
    }
  test::expectError(reachableSagCompensation(asset, {}), {"call process() on the asset"});
  test::expectOk(asset.process());
  SimulationSettings settings;
  settings.bendLength = 0.04f;
  std::vector<float> shares = test::valueOf(reachableSagCompensation(asset, settings));
  ASSERT_EQ(shares.size(), 2u);
  EXPECT_LT(shares[0], 0.9f);
  EXPECT_GT(shares[0], 0.01f);
  EXPECT_EQ(shares[1], 1);
  const std::vector<StrandFactors> stiff(2, {.stiffness = 30});
  EXPECT_EQ(test::valueOf(reachableSagCompensation(asset, settings, stiff))[0], 1);
  settings.gravity = {};
  EXPECT_EQ(test::valueOf(reachableSagCompensation(asset, settings))[0], 1);
  settings.bendLength = test::kNan;
  test::expectError(reachableSagCompensation(asset, settings), {"bendLength"});
  test::expectError(reachableSagCompensation(asset, {}, std::span(stiff).first(1)),
                    {"1 factors for 2 guides"});
}

// Not a limit: what the documentation says of the cost.
TEST(SagReach, CostOnTheHost) {
  SagRandom random(4);
  HairAsset asset;
  asset.strandCount = 2000;
  asset.verticesPerStrand = 32;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const Vector3d direction = rod::directionOr(random.cube(), Vector3d(1, 0, 0));
    for (const Vector3d& p : rod::straightPoints(32, 0.1, direction))
      asset.positions.push_back(
          {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 1});
  }
  test::expectOk(asset.process());
  for (const float bendLength : {0.2f, 0.01f}) {
    SimulationSettings settings;
    settings.bendLength = bendLength;
    const std::clock_t begin = std::clock();
    const auto shares = test::valueOf(reachableSagCompensation(asset, settings));
    const double took = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    size_t limp = 0;
    for (const float share : shares) limp += share < 1 ? 1 : 0;
    printf("    bend length %g m: %zu of %zu guides too limp, %.2f us a vertex\n",
           static_cast<double>(bendLength), limp, shares.size(),
           took / static_cast<double>(asset.positions.size()));
    EXPECT_EQ(limp > 0, bendLength < 0.1f);
  }
}

}  // namespace
}  // namespace pelage
