// Hair that hangs in its bind shape from the first frame on: SimulationSettings::sagCompensation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "pelage/demo/groom.h"
#include "pelage/gpu_structs.h"
#include "pelage/sag_compensation.h"
#include "support/scene_list_test.h"
#include "support/scene_test.h"
#include "support/strand_measures.h"

namespace pelage::test {
namespace {

constexpr uint32_t kSagStrands = 48, kSagVertices = 20;
constexpr float kSagBendLength = 0.06f;
// Hair at rest moves by less than this [m].
constexpr double kSagTolerance = 5e-4;

/// Curls and arcs of 4 to 20 cm in all directions.
HairAsset sagAsset(uint32_t seed) {
  std::mt19937 engine(seed);
  const auto between = [&](double a, double b) {
    return a + (b - a) * (static_cast<double>(engine()) / 4294967296.0);
  };
  const auto cube = [&] {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return Vector3d(x, y, z);
  };
  HairAsset asset;
  asset.strandCount = kSagStrands;
  asset.verticesPerStrand = kSagVertices;
  for (uint32_t s = 0; s < kSagStrands; ++s) {
    const double edge = between(0.04, 0.2) / (kSagVertices - 1);
    Vector3d p = 0.1 * cube(), direction = cube().normalized();
    const Vector3d along = direction, curl = between(0, 0.5) * cube();
    for (uint32_t v = 0; v < kSagVertices; ++v) {
      asset.positions.push_back(toFloat4(p, v < 2 ? 0 : 1));
      p += edge * direction;
      direction = (direction + curl.cross(direction) + 0.2 * along).normalized();
    }
  }
  expectOk(asset.process());
  return asset;
}

/// Only the guides that can hold their bind shape, or only the others.
HairAsset guidesThat(const HairAsset& asset, const SimulationSettings& settings, bool hold) {
  const std::vector<float> shares = valueOf(reachableSagCompensation(asset, settings));
  HairAsset kept;
  kept.verticesPerStrand = asset.verticesPerStrand;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    if ((shares[s] == 1) != hold) continue;
    ++kept.strandCount;
    const auto first = asset.positions.begin() + s * asset.verticesPerStrand;
    kept.positions.insert(kept.positions.end(), first, first + asset.verticesPerStrand);
  }
  expectOk(kept.process());
  return kept;
}

class SagScene : public SceneTest {
 protected:
  SagScene() {
    settings_.bendLength = kSagBendLength;
    settings_.sagCompensation = 1;
    // A sleeping strand would not show that it would move.
    settings_.sleep.enabled = false;
    asset_ = guidesThat(sagAsset(7), settings_, true);
  }
  /// The farthest that a vertex is from its bind position in the next frames [m].
  double movedIn(const HairObject& hair, int frames, const RigidMotion& motion = {}) {
    double farthest = 0;
    for (int frame = 0; frame < frames; ++frame) {
      run_.step();
      if (frame < 20 || frame % 30 == 0 || frame + 1 == frames)
        keepLargest(farthest, maxDistance(run_.positions(hair), asset_.positions, motion));
    }
    return farthest;
  }

  SimulationSettings settings_;
  HairAsset asset_;
};

TEST_P(SagScene, HairStaysInItsBindShapeForTenSeconds) {
  ASSERT_GE(asset_.strandCount, 20u);
  HairObject& hair = run_.add(asset_, {.settings = settings_});
  const double moved = movedIn(hair, 600);
  printf("    %s: %u strands moved by %.2g m in 10 s\n", apiName(GetParam()), asset_.strandCount,
         moved);
  EXPECT_LT(moved, kSagTolerance);
  run_.clear();
  settings_.sagCompensation = 0;
  EXPECT_GT(movedIn(run_.add(asset_, {.settings = settings_}), 60), 0.05);
}

TEST_P(SagScene, CurlsOfAHeadStayForTenSeconds) {
  GroomDef def;
  def.strandCount = 100;
  def.verticesPerStrand = 48;
  def.length = 0.2f;
  def.curlRadius = 0.01f;
  settings_.bendLength = 0.08f;
  asset_ = valueOf(generateGroom(def)).hair;
  expectOk(asset_.process());
  const std::vector<float> shares = valueOf(reachableSagCompensation(asset_, settings_));
  EXPECT_EQ(std::count(shares.begin(), shares.end(), 1.0f), 100);
  const double moved = movedIn(run_.add(asset_, {.settings = settings_}), 600);
  printf("    %s: moved by %.2g m in 10 s\n", apiName(GetParam()), moved);
  EXPECT_LT(moved, kSagTolerance);
}

TEST_P(SagScene, CurvesHeldVerticesAndGlobalShapeDoNotMoveIt) {
  settings_.globalStiffness = 0.1f;
  settings_.curves.stiffness = {2, 1.8f, 1.6f, 1.4f, 1.2f, 1, 0.8f, 0.6f};
  settings_.subSteps = 2;
  settings_.relaxationTime = 2e-3f;
  settings_.vspCoefficient = 0.9f;  // 0.4 of gravity acts
  for (uint32_t s = 0; s < asset_.strandCount; s += 3)
    asset_.positions[(s + 1) * kSagVertices - 1].w = 0;
  expectOk(asset_.process());
  asset_ = guidesThat(asset_, settings_, true);
  EXPECT_LT(movedIn(run_.add(asset_, {.settings = settings_}), 240), kSagTolerance);
}

TEST_P(SagScene, ResetsAndPausesBeginThere) {
  HairObject& hair =
      run_.add(asset_, {.settings = settings_, .boneCount = 1, .levelOfDetail = true});
  // Gravity is the same in the frame of the bind pose.
  const RigidMotion turned = RigidMotion::about(1.2, {0, 1, 0}, {0.3, 0.1, -2});
  setBone(hair, turned.transform());
  hair.reset();
  EXPECT_LT(movedIn(hair, 60, turned), kSagTolerance) << "a reset";
  hair.simulated = false;
  EXPECT_LT(movedIn(hair, 3, turned), kSagTolerance) << "not simulated";
  hair.simulated = true;
  EXPECT_LT(movedIn(hair, 90, turned), kSagTolerance) << "simulated again: gravity does not fade";
  hair.simulatedShare = 0.3f;
  EXPECT_LT(movedIn(hair, 30, turned), kSagTolerance) << "guides that follow others";
  hair.simulatedShare = 1;
  EXPECT_LT(movedIn(hair, 60, turned), kSagTolerance) << "all are simulated again";
  const RigidMotion away = {.shift = {5, 0, 3}};
  expectOk(run_.scene.teleport(run_.lastHair(), away.transform()));
  setBone(hair, (away * turned).transform());
  EXPECT_LT(movedIn(hair, 60, away * turned), kSagTolerance) << "a teleport";
}

TEST_P(SagScene, ChangesOfSettingsComputeTheRestShapeAgain) {
  HairObject& hair = run_.add(asset_, {.settings = settings_});
  movedIn(hair, 2);
  const BufferId rest = hair.buffers().rest;
  hair.settings.damping = 0.1f;
  movedIn(hair, 1);
  EXPECT_EQ(hair.buffers().rest, rest) << "damping does not bend hair";
  hair.settings.gravity = {0, -20, 0};
  hair.settings.bendLength = 0.12f;
  // The twist is another one.
  EXPECT_LT(movedIn(hair, 240), 0.05);
  EXPECT_LT(movedIn(hair, 1), kSagTolerance) << "stiffer hair under more gravity";
  hair.settings.sagCompensation = 0;
  EXPECT_GT(movedIn(hair, 120), 0.01);
  hair.settings.sagCompensation = 1;
  movedIn(hair, 300);
  EXPECT_LT(movedIn(hair, 1), kSagTolerance) << "hair that has fallen comes back";
}

TEST_P(SagScene, LimpHairSagsLessThanWithoutIt) {
  asset_ = guidesThat(sagAsset(11), settings_, false);
  ASSERT_GE(asset_.strandCount, 3u);
  double sag[2] = {};
  for (const int share : {0, 1}) {
    settings_.sagCompensation = static_cast<float>(share);
    HairObject& hair = run_.add(asset_, {.settings = settings_});
    movedIn(hair, 300);
    const std::vector<Float4> end = run_.positions(hair);
    for (size_t i = 0; i < end.size(); ++i) sag[share] += distance(end[i], asset_.positions[i]);
    run_.clear();
  }
  EXPECT_GT(sag[1], 0);
  EXPECT_LT(sag[1], sag[0]);
}

INSTANTIATE_TEST_SUITE_P(All, SagScene, testing::ValuesIn(kRuntimeApis), apiTestName);

class SagLists : public SceneListTest {};

TEST_F(SagLists, WithoutItThereIsNoSetOfBindJoints) {
  HairObject& hair = addHair();
  simulate();
  const uint64_t plain = scene_.resources().find(hair.buffers().rest)->size;
  const auto set = [&] { return constantsOf<ExactConstants>("simulate_exact").at(0).bindSet; };
  EXPECT_EQ(set(), 0u);
  hair.settings.sagCompensation = 1;
  hair.settings.gravity = {};
  simulate();
  EXPECT_EQ(set(), 0u) << "there is nothing to balance";
  EXPECT_EQ(scene_.resources().find(hair.buffers().rest)->size, plain);
  hair.settings.gravity = {0, -9.81f, 0};
  hair.settings.globalStiffness = 0.1f;
  hair.settings.curves.damping[3] = 2;
  simulate();
  EXPECT_EQ(set(), 2u);
  EXPECT_EQ(constantsOf<ExactConstants>("simulate_exact").at(0).parameterSet, 3u);
  hair.settings.solver = Solver::kClassic;
  simulate();
  const uint64_t classic = scene_.resources().find(hair.buffers().rest)->size;
  hair.settings.sagCompensation = 0;
  simulate();
  EXPECT_EQ(scene_.resources().find(hair.buffers().rest)->size, classic);
}

TEST_F(SagLists, CountsGuidesThatAreTooLimp) {
  const HairAsset asset = sagAsset(3);
  SimulationSettings settings;
  settings.bendLength = kSagBendLength;
  const std::vector<float> shares = valueOf(reachableSagCompensation(asset, settings));
  HairObject& hair = addHair({.settings = settings}, asset);
  for (const float asked : {0.0f, 0.3f, 1.0f}) {
    hair.settings.sagCompensation = asked;
    simulate();
    const auto limp =
        std::count_if(shares.begin(), shares.end(), [&](float share) { return share < asked; });
    EXPECT_EQ(hair.limpGuideCount(), limp) << asked;
    EXPECT_EQ(limp > 0, asked > 0) << asked;
  }
  hair.settings.solver = Solver::kClassic;
  simulate();
  EXPECT_EQ(hair.limpGuideCount(), 0u);
}

TEST_F(SagLists, RefusesSharesOutOfRange) {
  HairObject& hair = addHair();
  for (const float share : {-0.1f, 1.1f}) {
    hair.settings.sagCompensation = share;
    expectRefused({"sagCompensation"});
  }
}

}  // namespace
}  // namespace pelage::test
