// update_follow_hairs against the double-precision reference.
#include <gtest/gtest.h>

#include <cmath>

#include "reference/skinning_reference.h"
#include "support/extremes.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using reference::Pose;

class UpdateFollowHairs : public GpuTest {};

std::vector<FollowHairRecord> followHairRecords(uint32_t guides, uint32_t count) {
  Random random(8);
  std::vector<FollowHairRecord> strands(count);
  for (uint32_t f = 0; f < count; ++f) {
    strands[f].guides.x = f % guides;
    strands[f].weights.x = 1;
    strands[f].offset = toFloat4(random.vector(0.004), random.between(0, 2));
  }
  return strands;
}

std::vector<Pose> rotatedPoses(const HairAsset& asset) {
  Random random(2);
  std::vector<Pose> poses;
  for (uint32_t s = 0; s < asset.strandCount; ++s)
    poses.push_back({random.rotation(), random.vector(0.5)});
  return poses;
}

// K11
TEST_P(UpdateFollowHairs, TurnOffsetsWithTheRootForEveryCount) {
  struct Counts {
    uint32_t guides, follows, vertices;
  };
  for (const Counts size : {Counts{1, 1, 2}, Counts{3, 17, 5}, Counts{5, 63, 32}, Counts{5, 65, 31},
                            Counts{2, 9, 256}, Counts{4, 65537, 2}}) {
    SCOPED_TRACE(size.follows);
    const HairAsset asset = wavyAsset(size.guides, size.vertices);
    const std::vector<FollowHairRecord> follows = followHairRecords(size.guides, size.follows);
    StrandRun run(gpu(), asset, follows);
    const std::vector<Pose> poses = rotatedPoses(asset);
    run.constants.tipSeparation = 1.5f;
    run.resetWithFollowHairs(poses);
    run.checkGuards();
    const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
    const auto strand = [&](const std::vector<Float4>& from, uint32_t s) {
      std::vector<Vector3d> result;
      for (uint32_t v = 0; v < size.vertices; ++v)
        result.push_back(toVector(from[s * size.vertices + v]));
      return result;
    };
    double worst = 0, worstTangent = 0, worstMass = 0;
    for (uint32_t f = 0; f < size.follows; ++f) {
      const uint32_t g = follows[f].guides.x;
      const std::vector<Vector3d> expected =
          reference::followHair(strand(positions, g), poses[g].rotation,
                                toVector(follows[f].offset), double{follows[f].offset.w} * 1.5);
      const std::vector<Vector3d> actual = strand(positions, size.guides + f);
      const std::vector<Vector3d> tangent = strand(tangents, size.guides + f);
      for (uint32_t v = 0; v < size.vertices; ++v) {
        keepLargest(worst, (actual[v] - expected[v]).norm());
        const Vector3d along =
            expected[std::min(v + 1, size.vertices - 1)] - expected[v > 0 ? v - 1 : 0];
        keepLargest(worstTangent, (tangent[v] - along.normalized()).norm());
        keepLargest(worstMass, std::abs(double{positions[(size.guides + f) * size.vertices + v].w} -
                                        double{positions[g * size.vertices + v].w}));
      }
    }
    EXPECT_LT(worst, 5e-7);
    EXPECT_LT(worstTangent, 2e-3);  // 256 vertices: segments of 1 mm, rounded to 1e-7 m
    EXPECT_EQ(worstMass, 0);
  }
}

// K11
TEST_P(UpdateFollowHairs, KeepTheirPlaceOnAScalpThatTurns) {
  const HairAsset asset = wavyAsset(6, 8);
  const std::vector<FollowHairRecord> follows = followHairRecords(6, 24);
  StrandRun run(gpu(), asset, follows);
  const auto offsetsInRootSpace = [&](const std::vector<Pose>& poses) {
    run.resetWithFollowHairs(poses);
    const std::vector<Float4> positions = run.positions();
    std::vector<Vector3d> result;
    for (uint32_t f = 0; f < 24; ++f)
      result.push_back(
          poses[follows[f].guides.x].rotation.conjugate() *
          (toVector(positions[(6 + f) * 8]) - toVector(positions[follows[f].guides.x * 8])));
    return result;
  };
  const std::vector<Vector3d> before = offsetsInRootSpace(bindPoses(asset));
  const std::vector<Vector3d> after = offsetsInRootSpace(rotatedPoses(asset));
  for (uint32_t f = 0; f < 24; ++f) {
    EXPECT_LT((before[f] - toVector(follows[f].offset)).norm(), 1e-7) << "strand " << f;
    EXPECT_LT((after[f] - before[f]).norm(), 2e-7) << "strand " << f;
  }
}

// K11
TEST_P(UpdateFollowHairs, MixSeveralGuidesByWeightAndStayOnTheScalp) {
  const HairAsset asset = wavyAsset(5, 9);
  std::vector<FollowHairRecord> follows = followHairRecords(5, 20);
  for (uint32_t f = 0; f < 20; ++f) {
    follows[f].guides = {f % 5, (f + 2) % 5, (f + 3) % 5, 0};
    follows[f].weights = {0.5f, 0.3f, 0.2f, 0};
  }
  // Missing guides and zero weights add nothing, and the others keep their proportions.
  follows[3].guides.y = 5;
  follows[4].weights.z = -1;
  follows[5].weights.x = 0;
  StrandRun run(gpu(), asset, follows);
  // A rigid motion of the whole scalp.
  const Eigen::Quaterniond relativeRotation(
      Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()));
  const Vector3d shift(0.3, -0.2, 0.1);
  const std::vector<Pose> bind = bindPoses(asset);
  std::vector<Pose> moved;
  for (const Pose& pose : bind)
    moved.push_back({relativeRotation, relativeRotation * pose.position + shift});
  const auto positionsAt = [&](const std::vector<Pose>& poses) {
    run.resetWithFollowHairs(poses);
    run.checkGuards();
    return run.positions();
  };
  const std::vector<Float4> atBind = positionsAt(bind), after = positionsAt(moved);
  for (uint32_t f = 0; f < 20; ++f) {
    const uint32_t guides[3] = {follows[f].guides.x, follows[f].guides.y, follows[f].guides.z};
    const float given[3] = {follows[f].weights.x, follows[f].weights.y, follows[f].weights.z};
    double weights[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
      weights[k] = guides[k] < 5 && given[k] > 0 ? static_cast<double>(given[k]) : 0;
      sum += weights[k];
    }
    for (uint32_t v = 0; v < 9; ++v) {
      const double factor = 1 + (double{follows[f].offset.w} - 1) * v / 8;
      Vector3d expected = factor * toVector(follows[f].offset);
      for (int k = 0; k < 3; ++k) {
        if (weights[k] > 0) expected += weights[k] / sum * toVector(atBind[guides[k] * 9 + v]);
      }
      const size_t at = (5 + f) * 9 + v;
      EXPECT_LT((toVector(atBind[at]) - expected).norm(), 5e-7)
          << "strand " << f << " vertex " << v;
      EXPECT_LT((toVector(after[at]) - (relativeRotation * expected + shift)).norm(), 1e-6)
          << "strand " << f << " vertex " << v;
    }
  }
}

TEST_P(UpdateFollowHairs, AreTheSameBitsWithOneGuideWhateverItsWeight) {
  const HairAsset asset = wavyAsset(3, 7);
  std::vector<FollowHairRecord> follows = followHairRecords(3, 12);
  for (uint32_t f = 6; f < 12; ++f) {
    follows[f] = follows[f - 6];
    follows[f].weights.x = 0.7f;
    follows[f].guides.y = 9;
    follows[f].weights.y = 0.3f;
  }
  StrandRun run(gpu(), asset, follows);
  run.resetWithFollowHairs(rotatedPoses(asset));
  const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
  for (size_t i = 3 * 7; i < 9 * 7; ++i) {
    EXPECT_EQ(positions[i], positions[i + 6 * 7]);
    EXPECT_EQ(tangents[i], tangents[i + 6 * 7]);
  }
}

TEST_P(UpdateFollowHairs, LeaveStrandsWithoutAGuideAlone) {
  const HairAsset asset = wavyAsset(2, 4);
  std::vector<FollowHairRecord> follows = followHairRecords(2, 3);
  follows[0].guides.x = 2;
  follows[2].weights.x = 0;
  StrandRun run(gpu(), asset, follows);
  run.resetWithFollowHairs(rotatedPoses(asset));
  run.checkGuards();
  const std::vector<Float4> positions = run.positions();
  for (uint32_t v = 0; v < 4; ++v) {
    EXPECT_EQ(positions[2 * 4 + v], Float4{});
    EXPECT_NE(positions[3 * 4 + v], Float4{});
    EXPECT_EQ(positions[4 * 4 + v], Float4{});
  }
}

TEST_P(UpdateFollowHairs, TakeTheGuidesTangentWhereTheirOwnVerticesCoincide) {
  const HairAsset asset = wavyAsset(1, 3);
  std::vector<Vector3d> bind = bindOf(asset, 0);
  // An offset that puts all of the follow strand's vertices 0 and 2 in one place.
  FollowHairRecord follow = {};
  const Vector3d span = bind[2] - bind[0];
  follow.offset = toFloat4(span, 0);
  follow.weights.x = 1;
  StrandRun run(gpu(), asset, {follow});
  run.resetWithFollowHairs({bindPose(asset, 0)});
  for (const Float4& t : run.tangents()) EXPECT_NEAR(toVector(t).norm(), 1, 1e-5);
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Apis, UpdateFollowHairs, testing::ValuesIn(kApis), apiTestName);

}  // namespace pelage::test
