// Known defects of other hair libraries, for both solvers in a scene; the README lists them.
#include <numbers>

#include "stress/stress_run.h"

namespace pelage::test {
namespace {

class Defects : public StressTest {
 protected:
  Defects() {
    // See StressTest; none that could be seen.
    settings_.wind.velocity.z = 1e-9f;
    settings_.wind.gustStrength = settings_.wind.strandVariation = 0;
  }
  /// But for the rounding of large coordinates.
  static double stretch(const HairAsset& asset, const std::vector<Float4>& positions) {
    double worst = 0;
    for (uint32_t s = 0; s < asset.strandCount; ++s)
      keepLargest(worst, stretchOf(asset, positions, s, 1e-4));
    return worst;
  }
};

HairAsset straightAsset(const std::vector<uint32_t>& counts, double length,
                        const Vector3d& displacement) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(counts.size());
  asset.vertexCounts = counts;
  asset.verticesPerStrand = *std::max_element(counts.begin(), counts.end());
  for (uint32_t s = 0; s < counts.size(); ++s) {
    for (uint32_t v = 0; v < asset.verticesPerStrand; ++v) {
      const double share = static_cast<double>(std::min(v, counts[s] - 1)) / (counts[s] - 1);
      const Vector3d p = Vector3d(0.001 * s, 0, 0) + displacement * (length * share);
      asset.positions.push_back(toFloat4(p, v < 2 ? 0 : 1));
    }
  }
  expectOk(asset.process());
  return asset;
}

// K3, K6: in flight, and pressed onto a collider.
TEST_P(Defects, TangentsAreThoseOfThePositionsUpToTheTip) {
  const HairAsset asset = wavyAsset(33, 16);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 30; ++frame) {
    setCollider(hair, sphereCollider({0, -0.3f + 0.01f * static_cast<float>(frame), 0}, 0.15f));
    run_.step();
  }
  const std::vector<Float4> positions = run_.positions(hair);
  const std::vector<Float4> tangents = run_.read(hair.buffers().tangents);
  double worst = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    const size_t v = i % 16, before = v > 0 ? i - 1 : i, after = v < 15 ? i + 1 : i;
    const Vector3d across = toVector(positions[after]) - toVector(positions[before]);
    keepLargest(worst, (across.normalized() - toVector(tangents[i])).norm());
  }
  EXPECT_LT(worst, 1e-4);
  EXPECT_LT(stretch(asset, positions), 1e-3);
}

// K5
TEST_P(Defects, HangingHairIsAsLongAsItWasMadeForEveryVertexCount) {
  const HairAsset asset = straightAsset({8, 16, 32, 64, 128}, 0.3, {0.6, -0.8, 0});
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 120; ++frame) run_.step();
  EXPECT_LT(stretch(asset, run_.positions(hair)), 1e-3);
}

// K8
TEST_P(Defects, EveryVertexCountFrom2To256IsSimulatedInFull) {
  std::vector<uint32_t> counts;
  if (exact()) {
    for (uint32_t n = 2; n <= 256; ++n) counts.push_back(n);
  } else {
    counts = {2, 63, 64, 65, 256};
  }
  const HairAsset asset = straightAsset(counts, 0.3, {1, 0, 0});
  settings_.localStiffness = 0;
  settings_.bendLength = 0.02f;
  const HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 12; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(hair);
  EXPECT_LT(stretch(asset, positions), 1e-3);
  for (uint32_t s = 0; s < counts.size(); ++s) {
    if (counts[s] < 4) continue;
    const size_t tip = size_t{s} * asset.verticesPerStrand + counts[s] - 1;
    EXPECT_LT(positions[tip].y, -0.05f) << counts[s] << " vertices: the tip falls";
  }
}

// K8: the shape of 64 vertices is solved as often as that of a few more or less.
TEST_P(Defects, SixtyFourVerticesHoldTheirShapeAsTheirNeighboursDo) {
  const HairAsset asset = straightAsset({62, 64, 66}, 0.3, {1, 0, 0});
  settings_.localStiffness = 0.95f;
  settings_.localIterations = 10;
  settings_.gravity = {0, -0.2f, 0};
  const HairId id = add(asset, {.settings = settings_});
  for (int frame = 0; frame < 40; ++frame) run_.step();
  const std::vector<Float4> positions = run_.positions(run_.scene.hair(id));
  const auto sag = [&](uint32_t strand, uint32_t count) {
    return -double{positions[size_t{strand} * asset.verticesPerStrand + count - 1].y};
  };
  const double fewer = sag(0, 62), here = sag(1, 64), more = sag(2, 66);
  EXPECT_GT(fewer, 0.002) << "it hangs at all";
  EXPECT_NEAR(here, (fewer + more) / 2, 0.02 * fewer);
}

// K32
TEST_P(Defects, TwoObjectsMoveAsEachDoesAlone) {
  const HairAsset asset = wavyAsset(9, 12);
  SimulationSettings other = settings_;
  other.gravity = {0, 4, 0};
  other.damping = 0.4f;
  other.bendLength = 0.05f;
  const auto run = [&](const std::vector<SimulationSettings>& settings) {
    std::vector<HairId> ids;
    for (const SimulationSettings& s : settings) ids.push_back(add(asset, {.settings = s}));
    for (int frame = 0; frame < 20; ++frame) run_.step();
    std::vector<std::vector<Float4>> positions;
    for (const HairId id : ids) positions.push_back(run_.positions(run_.scene.hair(id)));
    for (const HairId id : ids) remove(id);
    return positions;
  };
  const auto first = run({settings_}), second = run({other}), both = run({settings_, other});
  EXPECT_FALSE(sameBits(first[0], second[0])) << "the settings make no difference";
  EXPECT_TRUE(sameBits(both[0], first[0]));
  EXPECT_TRUE(sameBits(both[1], second[0]));
}

// Gusts of strands in all phases take nothing from the mean wind, and add nothing to it.
TEST_P(Defects, GustsThatDifferFromStrandToStrandAverageOut) {
  constexpr uint32_t kStrands = 400, kVertices = 6;
  const HairAsset asset =
      straightAsset(std::vector<uint32_t>(kStrands, kVertices), 0.1, {0, -1, 0});
  settings_.gravity = {};
  settings_.wind = {.velocity = {0, 0, 0.5f}, .gustPeriod = 1000};
  const auto meanTip = [&](float strength, float variation) {
    settings_.wind.gustStrength = strength;
    settings_.wind.strandVariation = variation;
    const HairId id = add(asset, {.settings = settings_});
    for (int frame = 0; frame < 10; ++frame) run_.step();
    const std::vector<Float4> positions = run_.positions(run_.scene.hair(id));
    remove(id);
    double sum = 0;
    for (uint32_t s = 0; s < kStrands; ++s)
      sum += double{positions[size_t{s + 1} * kVertices - 1].z} / kStrands;
    return sum;
  };
  const double steady = meanTip(0, 0), together = meanTip(1, 0), apart = meanTip(1, 1);
  EXPECT_GT(steady, 1e-4) << "the wind blows";
  EXPECT_GT(std::abs(together - steady), 0.1 * steady) << "it gusts";
  EXPECT_LT(std::abs(apart - steady), 0.4 * std::abs(together - steady));
}

// K43: 16 KB hold 341 bones.
TEST_P(Defects, TheLastOfAThousandBonesMovesItsStrand) {
  constexpr uint32_t kBones = 1000;
  const HairAsset asset = wavyAsset(2, 8);
  std::vector<BoneInfluences> influences(2);
  influences[1].bones[0] = kBones - 1;
  influences[0].weights[0] = influences[1].weights[0] = 1;
  const HairId id =
      add(asset, {.settings = settings_, .influences = influences, .boneCount = kBones});
  HairObject& hair = run_.scene.hair(id);
  std::vector<AffineTransform> bones(kBones);
  for (int frame = 0; frame < 3; ++frame) {
    bones[kBones - 1].rows[0].w = 0.01f * static_cast<float>(frame);
    hair.setBones(bones);
    run_.step();
  }
  const std::vector<Float4> positions = run_.positions(hair);
  EXPECT_NEAR(positions[0].x, asset.positions[0].x, 1e-6);
  EXPECT_NEAR(positions[8].x, asset.positions[8].x + 0.02f, 1e-6);
}

// K7, K18
TEST_P(Defects, AMoveOf40Or200MetresTakesTheHairAlong) {
  const HairAsset asset = wavyAsset(9, 12);
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (const double displacement : {0.0, 40.0, 240.0, 40.0}) {
    AffineTransform bone;
    bone.rows[1].w = static_cast<float>(displacement);
    setBone(hair, bone);
    for (int frame = 0; frame < 2; ++frame) run_.step();
    const std::vector<Float4> positions = run_.positions(hair);
    EXPECT_LT(stretch(asset, positions), 0.02) << "rounding at 240 m included";
    for (size_t i = 0; i < positions.size(); i += 12)
      EXPECT_LT(std::abs(positions[i].y - asset.positions[i].y - static_cast<float>(displacement)),
                1e-4f);
  }
}

// K12: neither twist nor length is lost, whatever the share.
TEST_P(Defects, ShockPropagationCarriesTheWholeShapeThroughAHalfRotationInOneFrame) {
  const HairAsset asset = wavyAsset(17, 12);
  settings_.gravity = {};
  settings_.vspCoefficient = 1;
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (int frame = 0; frame < 5; ++frame) run_.step();
  const RigidMotion motion =
      RigidMotion::about(0.999 * std::numbers::pi, {1, 2, -0.5}, {0.2, -0.1, 0.3});
  setBone(hair, motion.transform());
  run_.step();
  EXPECT_LT(maxDistance(run_.positions(hair), asset.positions, motion), 1e-3) << "of 0.3 m";
}

// K12: gravity, wind and forces do not act at 1, whatever the root does.
TEST_P(Defects, AtFullShockPropagationHairMovesRigidlyWithItsRoot) {
  const HairAsset asset = wavyAsset(17, 12);
  settings_.vspCoefficient = 1;
  settings_.wind = {.velocity = {0, 1, 4}};
  HairObject& hair = run_.add(asset, {.settings = settings_});
  const std::vector<Float4> force(17 * 12, {0, -20, 5, 0.5f});
  hair.setForces(run_.add("forces", force));
  double worst = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const RigidMotion motion = RigidMotion::about(0.8 * std::sin(0.2 * frame), {1, 2, -0.5},
                                                  {0, 0.02 * frame, 0.1 * std::sin(0.3 * frame)});
    setBone(hair, motion.transform());
    run_.step(frame % 3 == 2 ? 1.0f / 40 : 1.0f / 60);
    keepLargest(worst, maxDistance(run_.positions(hair), asset.positions, motion));
  }
  EXPECT_LT(worst, 5e-5) << "of 0.3 m";
}

// K12: the share of gravity is 1 up to 0.75, and falls linearly to 0 at 1.
TEST_P(Defects, GravityFadesTowardsFullShockPropagation) {
  const HairAsset asset = straightAsset({12, 12}, 0.1, {1, 0, 0});
  settings_.damping = 0.2f;
  settings_.bendLength = 0.2f;
  settings_.globalStiffness = exact() ? 0.0f : 0.3f;
  settings_.globalRange = 1;
  std::vector<double> sags;
  for (const float share : {0.3f, 0.75f, 0.8125f, 0.875f, 0.9375f, 1.0f}) {
    settings_.vspCoefficient = share;
    const HairId id = add(asset, {.settings = settings_});
    for (int frame = 0; frame < 180; ++frame) run_.step();
    sags.push_back(-static_cast<double>(run_.positions(run_.scene.hair(id))[11].y));
    remove(id);
  }
  ASSERT_GT(sags[1], 1e-3);
  EXPECT_NEAR(sags[0], sags[1], 1e-4 * sags[1]);
  for (int i = 1; i < 6; ++i) {
    const double expected = sags[1] * (5 - i) / 4;
    EXPECT_NEAR(sags[static_cast<size_t>(i)], expected, 0.03 * sags[1]) << i;
  }
}

// K13: the root turns by 180 degrees, a little more or less, and nothing softens it.
TEST_P(Defects, HairComesBackToItsShapeAfterHalfRotations) {
  const HairAsset asset = straightAsset({12, 12, 12, 12}, 0.1, {0, -1, 0});
  settings_.gravity = {};
  settings_.damping = 0.2f;
  settings_.bendLength = 0.3f;
  settings_.vspCoefficient = 0;
  HairObject& hair = run_.add(asset, {.settings = settings_});
  for (const double degrees : {179.0, 180.0, 181.0, 360.0}) {
    const RigidMotion motion = RigidMotion::about(degrees / 180 * std::numbers::pi, {1, 0, 0});
    setBone(hair, motion.transform());
    for (int frame = 0; frame < 180; ++frame) run_.step();
    EXPECT_LT(maxDistance(run_.positions(hair), asset.positions, motion), 2e-3)
        << degrees << " degrees, of 0.1 m";
  }
}

// K14
TEST_P(Defects, ACapsuleWhoseEndsCoincideIsASphere) {
  const HairAsset asset = straightAsset({32, 32}, 0.3, {1, 0, 0});
  const CapsuleCollider ball = {
      .head = {0.1f, -0.1f, 0}, .headRadius = 0.08f, .tail = {0.1f, -0.1f, 0}, .tailRadius = 0.08f};
  HairObject& hair = run_.add(asset, {.settings = settings_});
  setCollider(hair, ball);
  double deepest = 0, nearest = 1;
  for (int frame = 0; frame < 240; ++frame) {
    run_.step();
    if (frame < 120) continue;
    for (const Float4& p : run_.positions(hair)) {
      const double outside =
          (toVector(p) - Vector3d(static_cast<double>(0.1f), static_cast<double>(-0.1f), 0))
              .norm() -
          static_cast<double>(0.08f);
      keepLargest(deepest, -outside);
      keepSmallest(nearest, outside);
    }
  }
  EXPECT_LT(deepest, 1e-3) << "metres";
  EXPECT_LT(nearest, 3e-3) << "the hair lies on it";
  EXPECT_LT(stretch(asset, run_.positions(hair)), 1e-3);
}

// K14: a sphere that turns about nothing moves past the hair in any direction and takes it along.
TEST_P(Defects, FrictionActsInEveryDirection) {
  settings_.localStiffness = 0.05f;
  // The bar below lies along x or along z; it moves along x in both cases.
  for (const bool along : {true, false}) {
    double tipAt[2] = {};
    for (const bool rough : {false, true}) {
      const HairAsset asset = straightAsset({24}, 0.3, {0, -0.28, 0.96});
      const HairId id = add(asset, {.settings = settings_});
      HairObject& hair = run_.scene.hair(id);
      for (int frame = 0; frame < 90; ++frame) {
        const float x = 0.001f * static_cast<float>(std::max(0, frame - 40));
        const Vector3d half = along ? Vector3d(1, 0, 0) : Vector3d(0, 0, 1);
        const Vector3d center(static_cast<double>(x), -0.17, 0.1);
        setCollider(hair, {.head = toFloat3(center - half),
                           .headRadius = 0.1f,
                           .tail = toFloat3(center + half),
                           .tailRadius = 0.1f,
                           .friction = rough ? 0.8f : 0.0f});
        run_.step();
      }
      tipAt[rough ? 1 : 0] = static_cast<double>(run_.positions(hair).back().x);
      remove(id);
    }
    EXPECT_GT(tipAt[1], tipAt[0] + 2e-3) << (along ? "along" : "across") << " the bar";
  }
}

// K15: hair leans the same way for either sign, the tip most of all, at any count of segments.
TEST_P(Defects, WindBlowsAlongItsVector) {
  settings_.bendLength = 0.15f;
  settings_.localStiffness = 0.3f;
  settings_.damping = 0.1f;
  double leanOf[2][2] = {};
  for (const int sign : {1, -1}) {
    settings_.wind.velocity = {0, 0, 3.0f * static_cast<float>(sign)};
    const HairAsset asset = straightAsset({12, 48}, 0.3, {0, -1, 0});
    const HairId id = add(asset, {.settings = settings_});
    const HairObject& hair = run_.scene.hair(id);
    for (int frame = 0; frame < 240; ++frame) run_.step();
    const std::vector<Float4> positions = run_.positions(hair);
    for (uint32_t s = 0; s < 2; ++s) {
      const size_t first = size_t{s} * asset.verticesPerStrand, tip = first + asset.vertexCounts[s];
      double before = 0;
      for (size_t i = first + 2; i < tip; ++i) {
        const double lean = sign * static_cast<double>(positions[i].z);
        EXPECT_GT(lean, before) << "strand " << s << ", vertex " << i - first;
        EXPECT_LT(std::abs(positions[i].x - positions[first].x), exact() ? 1e-4f : 1e-2f);
        before = lean;
      }
      leanOf[sign > 0 ? 0 : 1][s] = before;
    }
    remove(id);
  }
  for (uint32_t s = 0; s < 2; ++s) EXPECT_NEAR(leanOf[0][s], leanOf[1][s], 1e-4) << "strand " << s;
  if (exact()) {
    EXPECT_NEAR(leanOf[0][0], leanOf[0][1], 0.1 * leanOf[0][0]);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Defects, allSolversOnRuntimes(), solverTestName);

}  // namespace
}  // namespace pelage::test
