// The baselines of the simulation benchmark do what the methods that they stand for do, and the
// benchmark measures what it says.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include "simulation/measure.h"
#include "workbench_test.h"

namespace bench {
namespace {

using pelage::Api;
using pelage::Float4;
using pelage::HeadlessDevice;
using pelage::PassList;
using pelage::rod::axisAngle;
using pelage::rod::RootPose;
using pelage::rod::straightPoints;
using pelage::rod::Vector3d;

class Baseline : public WorkbenchTest {
 protected:
  Measurement measured(const BenchScene& scene, SolverKind kind, uint32_t effort) {
    const SceneReference reference(scene);
    auto row = measure(*workbench_, *copies_, scene, reference, {kind, effort});
    EXPECT_TRUE(row.ok()) << (row.ok() ? "" : row.error().message);
    return row.ok() ? *row : Measurement{};
  }

  /// The first strand after some frames of a scene without a measurement.
  Points moved(const BenchScene& scene, SolverKind kind, uint32_t effort, int frames) {
    auto solver = makeSolver(*workbench_, scene, {kind, effort});
    EXPECT_TRUE(solver.ok()) << (solver.ok() ? "" : solver.error().message);
    if (!solver.ok()) return {};
    PassList list;
    for (int frame = 0; frame < frames; ++frame) {
      EXPECT_TRUE((*solver)->advance(scene.motion(frame * kFrameSeconds), list).ok());
      EXPECT_TRUE(workbench_->run(list).ok());
    }
    const auto raw = device_->read((*solver)->positions());
    EXPECT_TRUE(raw.ok());
    Points points;
    for (uint32_t v = 0; raw.ok() && v < scene.asset.verticesPerStrand; ++v) {
      Float4 p;
      std::memcpy(&p, raw->data() + v * sizeof p, sizeof p);
      points.emplace_back(p.x, p.y, p.z);
    }
    return points;
  }
};

/// A horizontal strand of 0.3 m without stiffness, which comes to hang.
BenchScene limpStrand(int vertices, double airDrag) {
  BenchScene scene = limpSwing(3);
  pelage::HairAsset asset;
  asset.strandCount = 3;
  asset.verticesPerStrand = static_cast<uint32_t>(vertices);
  for (int s = 0; s < 3; ++s) {
    for (const Vector3d& p : straightPoints(vertices, 0.3, Vector3d(1, 0, 0)))
      asset.positions.push_back(
          {static_cast<float>(p.x), 0, 0, p.x < 0.3 * 1.5 / (vertices - 1) ? 0.0f : 1.0f});
  }
  EXPECT_TRUE(asset.process().ok());
  scene.asset = asset;
  scene.airDrag = airDrag;
  return scene;
}

double lengthOf(const Points& points) {
  double sum = 0;
  for (size_t i = 1; i < points.size(); ++i) sum += length(points[i] - points[i - 1]);
  return sum;
}

// K5: 8, 44 and 204 % with 8, 16 and 32 vertices.
TEST_P(Baseline, SweepsStretchAHangingStrandAsTheDefectIsDescribed) {
  const std::pair<int, double> cases[] = {{8, 8}, {16, 44}, {32, 204}};
  for (const auto& [vertices, stretch] : cases) {
    const Points points = moved(limpStrand(vertices, 4), SolverKind::kSweeps, 2, 1500);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(100 * (lengthOf(points) / 0.3 - 1), stretch, 0.1 * stretch + 2) << vertices;
  }
}

TEST_P(Baseline, SweepsStretchLessTheMoreThereAre) {
  double before = 1e9;
  for (const uint32_t sweeps : {2, 20, 100}) {
    const double stretch = measured(limpSwing(2), SolverKind::kSweeps, sweeps).rmsStretch;
    EXPECT_LT(stretch, 0.3 * before) << sweeps;
    before = stretch;
  }
  EXPECT_GT(before, 1);
}

TEST_P(Baseline, LeaveACurlInItsRestPoseWithoutGravity) {
  BenchScene scene = shakenCurl(2);
  scene.gravity = 0;
  scene.motion = [](double) { return RootPose(); };
  for (const SolverKind kind : {SolverKind::kSweeps, SolverKind::kCosserat}) {
    const Points points = moved(scene, kind, 10, 60);
    ASSERT_EQ(points.size(), 32u);
    for (size_t v = 0; v < points.size(); ++v) {
      const Float4& bind = scene.asset.positions[v];
      EXPECT_LT(length(points[v] - Vector3d(bind.x, bind.y, bind.z)), 1e-4) << solverName(kind);
    }
  }
}

TEST_P(Baseline, SweepsHoldAShortStrandUpByLocalShape) {
  BenchScene scene = limpStrand(4, 4);
  const double limp = -moved(scene, SolverKind::kSweeps, 20, 600).back().y;
  scene.localStiffness = 0.9f;
  const double stiff = -moved(scene, SolverKind::kSweeps, 20, 600).back().y;
  EXPECT_GT(limp, 0.15);
  EXPECT_LT(stiff, 0.5 * limp);
}

TEST_P(Baseline, SweepsHaveNoCodeForOtherVertexCounts) {
  EXPECT_FALSE(makeSweepsSolver(*workbench_, limpStrand(24, 0), 2).ok());
  EXPECT_FALSE(makeSweepsSolver(*workbench_, limpStrand(128, 0), 2).ok());
}

TEST_P(Baseline, SweepsCarryAStrandThatTakesPartInAllOfTheRootsMotion) {
  BenchScene scene = limpStrand(16, 0);
  scene.carry = 1;
  // Shifts and turns about the vertical, across the first edge: no twist is in it.
  scene.motion = [](double time) {
    return RootPose{axisAngle(Vector3d(0, 1, 0), 2 * time), Vector3d(time, 0, 0.5 * time)};
  };
  const int frames = 3;
  const Points points = moved(scene, SolverKind::kSweeps, 100, frames);
  const RootPose pose = scene.motion((frames - 1) * kFrameSeconds);
  ASSERT_EQ(points.size(), 16u);
  for (int v = 0; v < 16; ++v) {
    const Vector3d bound = pose.apply(Vector3d(0.3 * v / 15, 0, 0));
    const Vector3d d = points[static_cast<size_t>(v)] - bound;
    // Gravity alone: 3 h^2 g of fall at most.
    EXPECT_LT(length(Vector3d(d.x, 0, d.z)), 1e-3);
    EXPECT_LT(std::abs(d.y), 0.009);
  }
}

TEST_P(Baseline, CosseratRodsComeToHangStraightDown) {
  const Points points = moved(limpStrand(16, 5), SolverKind::kCosserat, 40, 900);
  ASSERT_EQ(points.size(), 16u);
  // Vertex 1 is held beside the root; the rest hangs from it.
  const Vector3d tip = points[15] - points[1];
  EXPECT_NEAR(-tip.y, 0.3 * 14 / 15, 0.003);
  EXPECT_LT(std::hypot(tip.x, tip.z), 0.003);
}

TEST_P(Baseline, CosseratRodsErrAndStretchLessTheMoreSubStepsThereAre) {
  double stretch = 1e9, error = 1e9;
  for (const uint32_t subSteps : {5, 10, 20, 40}) {
    const Measurement row = measured(limpSwing(2), SolverKind::kCosserat, subSteps);
    EXPECT_LT(row.rmsStretch, 0.5 * stretch) << subSteps;
    EXPECT_LT(row.error, 0.7 * error) << subSteps;
    stretch = row.rmsStretch;
    error = row.error;
  }
  EXPECT_LT(error, 1);
}

TEST_P(Baseline, CosseratRodsBendAndTwistAsTheReferenceDoes) {
  EXPECT_LT(measured(shakenCurl(2), SolverKind::kCosserat, 40).error, 2.5);
}

TEST_P(Baseline, CosseratRodsStartInTheBindPose) {
  BenchScene scene = shakenCurl(2);
  scene.motion = [](double) {
    return RootPose{axisAngle(Vector3d(0, 0, 1), 1.0), Vector3d(1, 2, 3)};
  };
  const Points points = moved(scene, SolverKind::kCosserat, 5, 1);
  ASSERT_EQ(points.size(), 32u);
  for (size_t v = 0; v < points.size(); ++v) {
    const Float4& bind = scene.asset.positions[v];
    EXPECT_LT(length(points[v] - scene.motion(0).apply(Vector3d(bind.x, bind.y, bind.z))), 1e-5);
  }
}

TEST_P(Baseline, AFloorIsMeasuredWhereThereAreTimestamps) {
  const auto small = copyFloor(*workbench_, 1024, 1024 * 64);
  const auto large = copyFloor(*workbench_, 65536, uint64_t{65536} * 640);
  ASSERT_TRUE(small.ok() && large.ok());
  if (*small == 0) GTEST_SKIP() << "no timestamps";
  EXPECT_GT(*large, *small);
}

INSTANTIATE_TEST_SUITE_P(Api, Baseline, testing::Values(Api::kVulkan, Api::kGl),
                         [](const testing::TestParamInfo<Api>& test) {
                           return std::string(pelage::apiName(test.param));
                         });

}  // namespace
}  // namespace bench
