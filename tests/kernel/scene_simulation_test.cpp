// What a scene's simulation does as a whole, with both solvers on every API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "kernel/strand_run.h"
#include "support/scene_run.h"

namespace pelage::test {
namespace {

class SceneSimulation : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  SceneSimulation() : run_(std::get<0>(GetParam())) { settings_.solver = std::get<1>(GetParam()); }
  void SetUp() override {
    if (run_.device() == nullptr) GTEST_SKIP() << "no device";
  }
  bool exact() const { return settings_.solver == Solver::kExact; }

  SceneRun run_;
  SimulationSettings settings_;
};

double distance(const Float4& a, const Float4& b) { return (toVector(a) - toVector(b)).norm(); }

AffineTransform shifted(double x) {
  AffineTransform bone;
  bone.rows[0].w = static_cast<float>(x);
  return bone;
}

/// Largest deviation of an edge from its rest length over that length.
double largestStretch(const HairAsset& asset, const std::vector<Float4>& positions) {
  double largest = 0;
  for (size_t i = 0; i + 1 < asset.positions.size(); ++i) {
    const double rest = static_cast<double>(asset.restLengths[i]);
    if (rest > 0)
      largest = std::max(largest, std::abs(distance(positions[i], positions[i + 1]) / rest - 1));
  }
  return largest;
}

TEST_P(SceneSimulation, TheBindPoseWithoutGravityStays) {  // K4
  const HairAsset asset = wavyAsset(40, 12);
  settings_.gravity = {};
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 60; ++frame) run_.step();
  const std::vector<Float4> first = run_.positions(hair);
  for (int frame = 0; frame < 60; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(hair);
  double fromBind = 0, drift = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    fromBind = std::max(fromBind, distance(positions[i], asset.positions[i]));
    drift = std::max(drift, distance(positions[i], first[i]));
  }
  EXPECT_LT(fromBind, 1e-5) << "of strands of 0.3 m";
  EXPECT_LT(drift, 1e-5);
}

TEST_P(SceneSimulation, AWalkOfHundredMetresIsTheMotionThatTheGroundDoesNotSee) {
  if (!exact()) GTEST_SKIP() << "the classic kernel has no origin yet";
  // Two runs with the same steps of the head; one starts 1 km away, where a float is 6e-5 m.
  const HairAsset asset = wavyAsset(33, 16);
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  const HairObject& away = run_.add(asset, {.name = "away", .settings = settings_});
  double largestStretchAway = 0;
  for (int frame = 0; frame < 120; ++frame) {
    // 16 m/s in steps that a float holds exactly.
    const double x = 0.25 * frame;
    for (const auto& [object, start] :
         {std::pair<const HairObject*, double>{&hair, 0}, {&away, 1024}}) {
      const AffineTransform bone = shifted(start + x);
      const_cast<HairObject*>(object)->setBones({&bone, 1});
    }
    run_.step();
  }
  const std::vector<Float4> here = run_.positions(hair), there = run_.positions(away);
  double largest = 0;
  for (size_t i = 0; i < here.size(); ++i) {
    const Float4 back = {there[i].x - 1024, there[i].y, there[i].z, 0};
    largest = std::max(largest, distance(here[i], back));
  }
  largestStretchAway = largestStretch(asset, here);
  EXPECT_LT(largest, 1e-4) << "the output's rounding at 1 km is 6e-5 m";
  EXPECT_LT(largestStretchAway, 1e-3);
}

TEST_P(SceneSimulation, TurnsWithTheSolverInTheMiddleOfARun) {
  const HairAsset asset = wavyAsset(20, 9);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 5; ++frame) run_.step();
  hair.settings.solver = exact() ? Solver::kClassic : Solver::kExact;
  run_.step();
  EXPECT_LT(largestStretch(asset, run_.positions(hair)), 1e-4);
  hair.settings.solver = settings_.solver;
  hair.settings.globalStiffness = 0.1f;
  for (int frame = 0; frame < 5; ++frame) run_.step();
  EXPECT_LT(largestStretch(asset, run_.positions(hair)), 1e-4);
}

TEST_P(SceneSimulation, StrandsOfDifferentCountsShareAnObject) {
  HairAsset asset = wavyAsset(70, 12);
  asset.vertexCounts.resize(70);
  for (uint32_t s = 0; s < 70; ++s) asset.vertexCounts[s] = 2 + (s * 7) % 11;
  expectOk(asset.process());
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 30; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(hair);
  EXPECT_LT(largestStretch(asset, positions), 1e-4);
  for (uint32_t s = 0; s < 70; ++s) {
    const size_t first = size_t{12} * s, tip = first + asset.vertexCounts[s] - 1;
    for (size_t i = tip; i < first + 12; ++i)
      EXPECT_LT(distance(positions[i], positions[tip]), exact() ? 1e-30 : 1e-4) << "strand " << s;
  }
}

std::string testName(const testing::TestParamInfo<std::tuple<Api, Solver>>& info) {
  return std::string(apiName(std::get<0>(info.param))) +
         (std::get<1>(info.param) == Solver::kExact ? "Exact" : "Classic");
}

INSTANTIATE_TEST_SUITE_P(All, SceneSimulation,
                         testing::Combine(testing::ValuesIn(kApis),
                                          testing::Values(Solver::kExact, Solver::kClassic)),
                         testName);

}  // namespace
}  // namespace pelage::test
