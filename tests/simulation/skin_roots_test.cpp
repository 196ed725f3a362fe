// skin_roots against singular values and dual quaternions in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reference/skinning_reference.h"
#include "support/extremes.h"
#include "support/not_numbers.h"
#include "support/skinning_bones.h"

namespace pelage::test {
namespace {

using reference::Matrix34d;
using reference::Pose;
using reference::WeightedBone;

Eigen::Quaterniond relativeRotation(double degrees, const Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
}

double degreesBetween(const RootTransform& root, const Eigen::Quaterniond& expected) {
  return toPose(root).rotation.normalized().angularDistance(expected) * 180 / std::numbers::pi;
}

double length(const Float4& q) {
  return std::sqrt(double{q.x} * double{q.x} + double{q.y} * double{q.y} +
                   double{q.z} * double{q.z} + double{q.w} * double{q.w});
}

/// Roots with bones of their own, four a root at most.
struct RootCase {
  std::vector<WeightedBone> bones;
};

/// The rotation of a bone without scale.
Eigen::Quaterniond rotationOf(const Matrix34d& bone) {
  return Eigen::Quaterniond(Eigen::Matrix3d(bone.leftCols<3>()));
}
/// How far a root is from where one bone has it [m].
double distanceFrom(const Matrix34d& bone, const RootTransform& root, const Vector3d& bindRoot) {
  return (toVector(root.position) - bone * bindRoot.homogeneous()).norm();
}

class SkinRoots : public GpuTest {
 protected:
  struct Outcome {
    HairAsset asset;
    std::vector<RootTransform> now, last;
    Vector3d bindRoot(uint32_t root) const {
      return toVector(asset.positions[size_t{root} * asset.verticesPerStrand]);
    }
  };

  Outcome skin(const std::vector<RootCase>& cases, bool dualQuaternions) {
    std::vector<Float4> bones;
    std::vector<RootBinding> bindings;
    for (const RootCase& root : cases) {
      RootBinding binding = {};
      std::vector<Matrix34d> transforms;
      const auto first = static_cast<uint32_t>(bones.size() / (dualQuaternions ? 2 : 3));
      for (uint32_t i = 0; i < root.bones.size(); ++i) {
        (&binding.bones.x)[i] = first + i;
        (&binding.weights.x)[i] = static_cast<float>(root.bones[i].weight);
        transforms.push_back(root.bones[i].transform);
      }
      const std::vector<Float4> rows = toBones(transforms, dualQuaternions);
      bones.insert(bones.end(), rows.begin(), rows.end());
      bindings.push_back(binding);
    }
    const HairAsset asset = wavyAsset(static_cast<uint32_t>(cases.size()), 3);
    StrandRun run(gpu(), asset, {}, bones, bindings);
    run.constants.boneCount = static_cast<uint32_t>(bones.size() / (dualQuaternions ? 2 : 3));
    run.constants.flags = 1;
    run.skinRoots(dualQuaternions);
    run.run();
    run.checkGuards();
    return split(asset, run.roots());
  }

  static Outcome skinned(StrandRun& run, const HairAsset& asset, bool dualQuaternions = false) {
    run.skinRoots(dualQuaternions);
    run.run();
    return split(asset, run.roots());
  }
  static Outcome split(const HairAsset& asset, const std::vector<RootTransform>& roots) {
    const auto half = roots.begin() + static_cast<ptrdiff_t>(roots.size() / 2);
    return {asset, {roots.begin(), half}, {half, roots.end()}};
  }
};

TEST_P(SkinRoots, MatchesTheNearestRotationOfBlendedMatrices) {
  Random random(3);
  std::vector<RootCase> cases;
  for (int i = 0; i < 500; ++i) {
    RootCase root;
    const Eigen::Quaterniond base = random.rotation();
    // The same bone scales for a root, as a scaled skeleton has.
    const double scale = std::pow(10.0, random.between(-2, 2));
    const Eigen::DiagonalMatrix<double, 3> stretch(scale * random.between(0.4, 2), scale,
                                                   scale * random.between(0.4, 2));
    for (int b = 0; b <= i % 4; ++b) {
      const Eigen::Quaterniond rotation =
          relativeRotation(b == 0 ? 0 : random.between(0, 85), random.vector(1)) * base;
      Matrix34d m = rigidMatrix(rotation, random.vector(2));
      m.leftCols<3>() =
          m.leftCols<3>() * (i % 3 == 0 ? Eigen::Matrix3d(stretch) : Eigen::Matrix3d::Identity());
      root.bones.push_back({rounded(m), static_cast<float>(random.between(0.1, 3))});
    }
    cases.push_back(root);
  }
  const Outcome outcome = skin(cases, false);
  for (uint32_t i = 0; i < cases.size(); ++i) {
    const Pose expected = reference::skinByMatrices(cases[i].bones, outcome.bindRoot(i));
    const double size = 1 + expected.position.norm();
    EXPECT_LT((toVector(outcome.now[i].position) - expected.position).norm(), 2e-6 * size) << i;
    EXPECT_LT(degreesBetween(outcome.now[i], expected.rotation), 0.04) << "root " << i;
    EXPECT_NEAR(length(outcome.now[i].rotation), 1, 1e-6) << "root " << i;
    EXPECT_EQ(outcome.now[i].rotation, outcome.last[i].rotation) << "reset sets both frames";
    EXPECT_EQ(outcome.now[i].position, outcome.last[i].position);
  }
}

TEST_P(SkinRoots, MatchesDualQuaternionBlendingOnTheShorterWay) {
  Random random(5);
  std::vector<RootCase> cases;
  for (int i = 0; i < 500; ++i) {
    RootCase root;
    const Eigen::Quaterniond base = random.rotation();
    for (int b = 0; b <= i % 4; ++b)
      root.bones.push_back(
          {rigidMatrix(
               relativeRotation(b == 0 ? 0 : random.between(0, 85), random.vector(1)) * base,
               random.vector(2)),
           static_cast<float>(random.between(0.1, 3))});
    cases.push_back(root);
  }
  const Outcome outcome = skin(cases, true);
  for (uint32_t i = 0; i < cases.size(); ++i) {
    const Pose expected = reference::skinByDualQuaternions(cases[i].bones, outcome.bindRoot(i));
    EXPECT_LT((toVector(outcome.now[i].position) - expected.position).norm(), 5e-6) << "root " << i;
    EXPECT_LT(degreesBetween(outcome.now[i], expected.rotation), 1e-4) << "root " << i;
    EXPECT_NEAR(length(outcome.now[i].rotation), 1, 1e-6) << "root " << i;
  }
}

TEST_P(SkinRoots, IsExactForOneBone) {
  std::vector<RootCase> cases;
  Random random(6);
  for (int i = 0; i < 100; ++i)
    cases.push_back({{{rounded(rigidMatrix(random.rotation(), random.vector(2))), 0.3}}});
  for (const bool dual : {false, true}) {
    const Outcome outcome = skin(cases, dual);
    for (uint32_t i = 0; i < cases.size(); ++i) {
      const Matrix34d& m = cases[i].bones[0].transform;
      EXPECT_LT(degreesBetween(outcome.now[i], rotationOf(m)), 5e-5);
      EXPECT_LT(distanceFrom(m, outcome.now[i], outcome.bindRoot(i)), 2e-6);
    }
  }
}

// K10
TEST_P(SkinRoots, GivesProperRotationsForScaledAndMirroredBones) {
  std::vector<RootCase> cases;
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Quaterniond base = random.rotation();
    // Up to 1:10 between the axes.
    const Eigen::DiagonalMatrix<double, 3> scale((i % 2 == 0 ? -1 : 1) * random.between(0.3, 3),
                                                 (i % 3 == 0 ? -1 : 1) * random.between(0.3, 3),
                                                 random.between(0.3, 3));
    Matrix34d m = rigidMatrix(base, random.vector(1));
    m.leftCols<3>() = m.leftCols<3>() * scale;
    cases.push_back({{{rounded(m), 1}}});
  }
  const Outcome outcome = skin(cases, false);
  for (uint32_t i = 0; i < cases.size(); ++i) {
    const Eigen::Matrix3d m = cases[i].bones[0].transform.leftCols<3>();
    EXPECT_NEAR(length(outcome.now[i].rotation), 1, 1e-6) << "root " << i;
    EXPECT_LT(degreesBetween(outcome.now[i], reference::nearestRotation(m)), 0.01) << "root " << i;
  }
}

TEST_P(SkinRoots, TakesTheStrongestBoneWhereTheBlendHasNoRotation) {
  const Vector3d axis(1, 2, 3);
  std::vector<RootCase> cases;
  for (const double degrees : {125.0, 150.0, 179.0, 180.0}) {
    cases.push_back(
        {{{rounded(rigidMatrix(relativeRotation(0, axis), {0, 0, 0})), 0.5f},
          {rounded(rigidMatrix(relativeRotation(degrees, axis), {1, 0, 0})), 0.500001f}}});
    const Matrix34d mirrored =
        rounded((Matrix34d() << -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0).finished());
    cases.push_back({{{mirrored, 0.4f},
                      {rounded(rigidMatrix(relativeRotation(degrees, axis), {0, 1, 0})), 0.5f}}});
  }
  const Outcome outcome = skin(cases, false);
  for (uint32_t i = 0; i < cases.size(); ++i) {
    const Pose expected = reference::skinByMatrices(cases[i].bones, outcome.bindRoot(i));
    EXPECT_LT(degreesBetween(outcome.now[i], rotationOf(cases[i].bones[1].transform)), 0.01)
        << "case " << i;
    EXPECT_LT(degreesBetween(outcome.now[i], expected.rotation), 0.01) << "case " << i;
    // The root stays on a skin that the same bones blend.
    EXPECT_LT((toVector(outcome.now[i].position) - expected.position).norm(), 1e-6);
  }
}

// K10
TEST_P(SkinRoots, GivesTheFirstBoneAllWeightWhereThereIsNone) {
  const Matrix34d bone = rounded(rigidMatrix(relativeRotation(40, {0, 1, 1}), {0.1, 0.2, 0.3}));
  for (const bool dual : {false, true}) {
    const Outcome outcome =
        skin({{{{bone, 0}, {bone, 0}}}, {{{bone, -1}}}, {{{bone, kNan}}}, {{{bone, kInf}}}}, dual);
    for (uint32_t i = 0; i < 4; ++i) {
      EXPECT_LT(degreesBetween(outcome.now[i], rotationOf(bone)), 1e-3) << "root " << i;
      EXPECT_LT(distanceFrom(bone, outcome.now[i], outcome.bindRoot(i)), 1e-6);
    }
  }
}

TEST_P(SkinRoots, SkipsBonesThatDoNotExist) {
  const HairAsset asset = wavyAsset(3, 3);
  std::vector<RootBinding> bindings(3);
  bindings[0].bones = {7, 0, 0xffffffffu, 0};
  bindings[0].weights = {0.9f, 0.1f, 0.5f, 0};
  bindings[1].bones = {1, 2, 3, 4};  // none of them exists
  bindings[1].weights = {1, 1, 1, 1};
  bindings[2].bones = {0x55555556u, 0, 0, 0};  // times 3 is 2 again in 32 bits
  bindings[2].weights = {1, 0, 0, 0};
  const Matrix34d bone = rounded(rigidMatrix(relativeRotation(70, {1, 0, 1}), {0.5, 0, 0}));
  StrandRun run(gpu(), asset, {}, toBones({bone}), bindings);
  const Outcome outcome = skinned(run, asset);
  EXPECT_LT(degreesBetween(outcome.now[0], rotationOf(bone)), 1e-3);
  for (uint32_t i : {1u, 2u}) {
    // Never skinned before: the bind pose.
    EXPECT_LT(degreesBetween(outcome.now[i], Eigen::Quaterniond::Identity()), 1e-6);
    EXPECT_EQ(toVector(outcome.now[i].position), outcome.bindRoot(i));
  }
}

TEST_P(SkinRoots, KeepsTheLastFrameAndStaysThereForBonesThatAreNotNumbers) {
  for (const bool dual : {false, true}) {
    const HairAsset asset = wavyAsset(5, 3);
    const Matrix34d bone = rounded(rigidMatrix(relativeRotation(50, {0, 0, 1}), {0, 1, 0}));
    const Matrix34d next = rounded(rigidMatrix(relativeRotation(-20, {1, 0, 1}), {0.2, 0, 0}));
    StrandRun run(gpu(), asset, {}, toBones({bone}, dual));
    run.constants.boneCount = 1;
    const Outcome first = skinned(run, asset, dual);

    run.setBones(toBones({next}, dual));
    const Outcome second = skinned(run, asset, dual);
    for (uint32_t i = 0; i < 5; ++i) {
      EXPECT_EQ(second.last[i].rotation, first.now[i].rotation);
      EXPECT_EQ(second.last[i].position, first.now[i].position);
      EXPECT_GT(degreesBetween(second.now[i], toPose(first.now[i]).rotation), 10);
    }

    for (const float broken : {kNan, kInf, 3e38f}) {
      std::vector<Float4> bones = toBones({next}, dual);
      bones[1].y = broken;
      run.setBones(bones);
      const Outcome third = skinned(run, asset, dual);
      for (uint32_t i = 0; i < 5; ++i) {
        EXPECT_EQ(third.now[i].rotation, second.now[i].rotation) << broken;
        EXPECT_EQ(third.now[i].position, second.now[i].position) << broken;
      }
    }
  }
}

TEST_P(SkinRoots, KeepsTheLastRotationForABoneWithoutVolume) {
  const HairAsset asset = wavyAsset(4, 3);
  const Matrix34d bone = rounded(rigidMatrix(relativeRotation(50, {0, 0, 1}), {0, 1, 0}));
  Matrix34d zero = Matrix34d::Zero();
  zero.col(3) = Vector3d(1, 2, 3);
  {
    StrandRun run(gpu(), asset, {}, toBones({bone}));
    run.skinRoots();
    run.setBones(toBones({bone}));
    run.run();
    const Outcome first = split(asset, run.roots());
    Matrix34d flat = bone;
    flat.col(1).setZero();
    for (const Matrix34d& broken : {zero, flat}) {
      run.setBones(toBones({broken}));
      const Outcome outcome = skinned(run, asset);
      for (uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(outcome.now[i].rotation, first.now[i].rotation);
        EXPECT_LT(distanceFrom(broken, outcome.now[i], outcome.bindRoot(i)), 1e-6);
      }
    }
  }
  StrandRun run(gpu(), asset, {}, toBones({zero}));
  run.skinRoots();
  run.run();
  for (const RootTransform& root : run.roots())
    EXPECT_EQ(root.rotation, (Float4{0, 0, 0, 1})) << "no frame before: the bind pose";
}

TEST_P(SkinRoots, TakesAnyNumberOfRoots) {
  for (const uint32_t count : {1u, 63u, 64u, 65u, 65537u}) {
    const HairAsset asset = wavyAsset(count, 2);
    const Matrix34d bone = rounded(rigidMatrix(relativeRotation(50, {0, 0, 1}), {0, 1, 0}));
    StrandRun run(gpu(), asset, {}, toBones({bone}));
    const Outcome outcome = skinned(run, asset);
    run.checkGuards();
    double worst = 0;
    for (uint32_t i = 0; i < count; ++i)
      keepLargest(worst, distanceFrom(bone, outcome.now[i], outcome.bindRoot(i)));
    EXPECT_LT(worst, 1e-6) << count << " roots";
  }
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Apis, SkinRoots, testing::ValuesIn(kApis), apiTestName);

}  // namespace pelage::test
