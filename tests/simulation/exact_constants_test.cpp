// The host packs the same constants for the exact solver as the reference takes: the tests of the
// reference hold the figures, and the kernels have its bits for numbers of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "../reference/rod/exact_rod.h"
#include "simulation/exact_solver.h"
#include "support/errors.h"

namespace pelage {
namespace {

using rod::RestStrand;
using rod::RodTuning;
using rod::Vector3d;

HairAsset strandOf(const std::vector<Vector3d>& points) {
  HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = static_cast<uint32_t>(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    asset.positions.push_back({static_cast<float>(points[i].x), static_cast<float>(points[i].y),
                               static_cast<float>(points[i].z), i < 2 ? 0.0f : 1.0f});
  test::expectOk(asset.process());
  return asset;
}

TEST(ExactRest, HasTheRegionsOfTheReference) {
  std::vector<std::vector<Vector3d>> strands = {
      rod::straightPoints(8, 0.2, Vector3d(1, 0, 0)),
      rod::straightPoints(3, 0.2, Vector3d(0, -1, 0)),
      rod::helixPoints(32, 0.008, 0.06, 4),
      // All but over after edge 0, where the length of the root's joint has its bound.
      {Vector3d(0, 0, 0), Vector3d(0.1, 0, 0), Vector3d(0.101, 0, 0)}};
  std::vector<Vector3d> uneven;
  for (int i = 0; i < 16; ++i) uneven.emplace_back(0.02 * std::pow(i, 1.5), 0.01 * i, 0);
  strands.push_back(uneven);
  for (const auto& points : strands) {
    const RestStrand expected(points);
    const HairAsset asset = strandOf(points);
    const detail::ExactStrands packed = detail::packExactStrands(asset, false);
    const std::vector<Float4> rest = detail::packExactRest(asset, packed, {});
    for (uint32_t i = 1; i < asset.verticesPerStrand; ++i) {
      const double voronoiLength =
          static_cast<double>(rest[packed.strands[0].state + size_t{exact::kTileStrands} * i].w);
      EXPECT_NEAR(voronoiLength, expected.voronoiLengths[i], 1e-5 * expected.voronoiLengths[i])
          << "vertex " << i << " of " << points.size();
    }
  }
}

// The share of the gusts that repeats after `period`, by Fourier's sum over many of them.
double gustAt(const WindSettings& wind, double period) {
  constexpr int kPeriods = 200, kSamples = 32;
  double cosines = 0, sines = 0;
  for (int i = 0; i < kPeriods * kSamples; ++i) {
    const double time = period * i / kSamples, phase = 2 * std::numbers::pi * i / kSamples;
    const double speed = static_cast<double>(detail::airAt(wind, time).velocity.x);
    cosines += speed * std::cos(phase);
    sines += speed * std::sin(phase);
  }
  return 2 * std::hypot(cosines, sines) / (kPeriods * kSamples);
}

TEST(Gusts, ComeInTheirPeriodAndAroundTheMean) {
  for (const float period : {0.5f, 2.5f, 40.0f}) {
    const WindSettings wind = {.velocity = {3, 0, 0}, .gustStrength = 0.5f, .gustPeriod = period};
    EXPECT_NEAR(gustAt(wind, double{period}), 3 * 0.5 * 0.6, 0.01);
    for (const double other : {0.7, 1.3, 2.0})
      EXPECT_LT(gustAt(wind, other * double{period}), 0.02) << other << " of " << period << " s";
    double sum = 0;
    for (int i = 0; i < 6400; ++i)
      sum += static_cast<double>(detail::airAt(wind, double{period} * i / 32).velocity.x);
    EXPECT_NEAR(sum / 6400, 3, 0.01);
  }
}

TEST(ExactStep, HasTheTuningOfTheReference) {
  for (const double h : {1 / 30.0, 1 / 60.0, 1 / 240.0, 1 / 1920.0}) {
    for (const float damping : {0.0f, 0.01f, 0.06f, 0.5f, 1.0f}) {
      for (const float twistRatio : {0.05f, 0.39f, 0.4f, 0.75f, 10.0f}) {
        SimulationSettings settings;
        settings.damping = damping;
        settings.twistRatio = twistRatio;
        ExactConstants constants = {};
        detail::ExactHistory history;
        detail::setExactStep(constants, settings, h, history, {});
        const double drag = -60 * std::log(1 - std::min(static_cast<double>(damping), 0.9999));
        const auto ratio = static_cast<double>(twistRatio);
        using Tuning = RodTuning<float>;
        EXPECT_FLOAT_EQ(constants.passTolerance,
                        static_cast<float>(Tuning::passTolerance(h, drag, ratio)));
        EXPECT_FLOAT_EQ(constants.twistInertia, Tuning::twistInertia(h));
        EXPECT_FLOAT_EQ(constants.slowRotation, Tuning::slowRotation(h, drag));
        EXPECT_FLOAT_EQ(constants.guessTrend, Tuning::guessTrend(drag));
      }
    }
  }
}

}  // namespace
}  // namespace pelage
