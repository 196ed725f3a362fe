// The oracle of distances against solutions in closed form and against brute force.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "support/extremes.h"

namespace pelage::reference {
namespace {

std::vector<Vector3d> randomPoints(size_t count, double halfWidth) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-halfWidth, halfWidth);
  std::vector<Vector3d> points(count);
  for (Vector3d& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

double boxDistance(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

Vector3d corner(const TriangleMesh& mesh, uint32_t triangle, uint32_t k) {
  const Float3& p = mesh.positions[mesh.indices[size_t{triangle} * 3 + k]];
  return {p.x, p.y, p.z};
}

TEST(MeshShapes, AreClosedWhereTheySaySo) {
  for (const TriangleMesh& mesh :
       {sphere(1, 9, 14), torus(1, 0.3f, 17, 8), cube(1), plate(1, 0.02f, 5, 0.7f), blob(9, 11),
        overlappingSpheres(1, 1.2f, 8, 9), unwelded(cube(1))})
    EXPECT_TRUE(DistanceOracle(mesh).isClosed());
  EXPECT_FALSE(DistanceOracle(sphereWithHoles(1, 9, 14, 20)).isClosed());
}

TEST(MeshShapes, TheSameCallGivesTheSameMesh) {
  EXPECT_EQ(blob(9, 11), blob(9, 11));
  EXPECT_EQ(plate(1, 0.1f, 4, 1), plate(1, 0.1f, 4, 1));
}

TEST(DistanceOracle, HasTheDistanceOfABox) {
  const DistanceOracle oracle(box({-1, -0.5f, -0.25f}, {1, 0.5f, 0.25f}));
  for (const Vector3d& p : randomPoints(3000, 2))
    ASSERT_NEAR(oracle.signedDistance(p), boxDistance(p, {1, 0.5, 0.25}), 1e-12) << p.transpose();
}

TEST(DistanceOracle, HasTheDistanceOfASphereButForItsFacets) {
  const DistanceOracle oracle(sphere(1, 200, 400));
  for (const Vector3d& p : randomPoints(2000, 1.6))
    ASSERT_NEAR(oracle.signedDistance(p), p.norm() - 1, 1.3e-4) << p.transpose();
}

TEST(DistanceOracle, AgreesWithBruteForce) {
  const TriangleMesh mesh = blob(14, 22);
  const DistanceOracle oracle(mesh);
  for (const Vector3d& p : randomPoints(400, 1.5)) {
    ClosestPoint best{1e300, p, 0, TriangleFeature::kFace};
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      ClosestPoint found =
          closestOnTriangle(p, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
      found.triangle = t;
      if (found.distance < best.distance) best = found;
    }
    const ClosestPoint found = oracle.closest(p);
    ASSERT_EQ(found.triangle, best.triangle);
    ASSERT_EQ(found.distance, best.distance);
    ASSERT_EQ(found.feature, best.feature);
    ASSERT_NEAR((found.point - p).norm(), found.distance, 1e-14);
  }
}

// No point of the triangle is nearer, and the one that is named lies on its feature.
TEST(DistanceOracle, ClosestPointOfATriangleIsTheClosest) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0.2, 0.7, 0.1);
  for (const Vector3d& p : randomPoints(300, 1.5)) {
    const ClosestPoint found = closestOnTriangle(p, a, b, c);
    double sampled = 1e300;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int k = 0; k + i <= kSteps; ++k)
        test::keepSmallest(sampled, (p - (a + (b - a) * i / kSteps + (c - a) * k / kSteps)).norm());
    ASSERT_LE(found.distance, sampled + 1e-12);
    ASSERT_GE(found.distance, sampled - 1.0 / kSteps);
  }
  EXPECT_EQ(closestOnTriangle({0.4, 0.2, 0.5}, a, b, c).feature, TriangleFeature::kFace);
  EXPECT_EQ(closestOnTriangle({0.5, -1, 0}, a, b, c).feature, TriangleFeature::kEdge01);
  EXPECT_EQ(closestOnTriangle({0.9, 0.9, 0}, a, b, c).feature, TriangleFeature::kEdge12);
  EXPECT_EQ(closestOnTriangle({-0.5, 0.4, 0}, a, b, c).feature, TriangleFeature::kEdge20);
  EXPECT_EQ(closestOnTriangle({-1, -1, 0}, a, b, c).feature, TriangleFeature::kVertex0);
  EXPECT_EQ(closestOnTriangle({3, 0, 0}, a, b, c).feature, TriangleFeature::kVertex1);
  EXPECT_EQ(closestOnTriangle({0.2, 3, 0.1}, a, b, c).feature, TriangleFeature::kVertex2);
}

TEST(DistanceOracle, WindingNumberIsWholeOnClosedMeshes) {
  const TriangleMesh mesh = overlappingSpheres(1, 1, 24, 30);
  const DistanceOracle oracle(mesh);
  for (const Vector3d& p : randomPoints(300, 2)) {
    const double left = (p - Vector3d(-0.5, 0, 0)).norm(), right = (p - Vector3d(0.5, 0, 0)).norm();
    if (std::abs(left - 1) < 0.02 || std::abs(right - 1) < 0.02) continue;
    ASSERT_NEAR(oracle.windingNumber(p), (left < 1 ? 1 : 0) + (right < 1 ? 1 : 0), 1e-9);
  }
  // Inside out: -1, which is outside.
  const DistanceOracle inverted(mirroredMesh(cube(1)));
  EXPECT_NEAR(inverted.windingNumber({0.1, 0.2, 0.3}), -1, 1e-12);
  EXPECT_FALSE(inverted.isInside({0.1, 0.2, 0.3}));
}

// A disc that is seen under a solid angle omega has w = omega / 4 pi.
TEST(DistanceOracle, WindingNumberOfAnOpenMeshIsItsSolidAngle) {
  TriangleMesh disc;
  disc.positions.push_back({0, 0, 0});
  constexpr uint32_t kSegments = 2000;
  for (uint32_t i = 0; i < kSegments; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSegments;
    disc.positions.push_back(
        {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0});
    disc.indices.insert(disc.indices.end(), {0, 1 + i, 1 + (i + 1) % kSegments});
  }
  const DistanceOracle oracle(disc);
  for (const double z : {-3.0, -0.5, -0.01, 0.02, 1.0}) {
    const double share = (1 - std::abs(z) / std::sqrt(1 + z * z)) / 2;
    EXPECT_NEAR(oracle.windingNumber({0, 0, z}), z < 0 ? share : -share, 1e-5);
  }
}

TEST(DistanceOracle, FastWindingNumberIsWithinItsMargin) {
  for (const TriangleMesh& mesh :
       {blob(30, 40), sphereWithHoles(1, 30, 40, 7), plate(2, 0.05f, 16, 0.6f),
        overlappingSpheres(0.8f, 0.9f, 24, 30), torus(1, 0.3f, 40, 20)}) {
    const DistanceOracle oracle(mesh);
    double worst = 0;
    for (const Vector3d& p : randomPoints(1500, 1.5))
      test::keepLargest(worst, std::abs(oracle.fastWindingNumber(p) - oracle.windingNumber(p)));
    EXPECT_LT(worst, 0.1);
    EXPECT_GT(worst, 1e-9);  // else it saves nothing
  }
}

TEST(DistanceOracle, ManyPointsGiveWhatSinglePointsGive) {
  // The side of an open mesh changes in the opening, where no surface is.
  TriangleMesh bowl = sphere(0.9f, 20, 30);
  bowl.indices.resize(bowl.indices.size() / 2);
  bowl = rotated(std::move(bowl), {0, 1, 0}, 1.2f);
  for (const TriangleMesh& mesh : {blob(20, 30), sphereWithHoles(1, 20, 30, 9), bowl}) {
    const DistanceOracle oracle(mesh);
    const uint32_t nodes[3] = {17, 13, 11};
    const Vector3d origin(-1.2, -0.9, -0.8);
    const std::vector<double> all = oracle.gridDistances(origin, 0.15, nodes);
    const std::vector<double> near = oracle.gridDistances(origin, 0.15, nodes, 0.3);
    size_t i = 0;
    for (uint32_t z = 0; z < 11; ++z)
      for (uint32_t y = 0; y < 13; ++y)
        for (uint32_t x = 0; x < 17; ++x, ++i) {
          const double single = oracle.signedDistance(origin + 0.15 * Vector3d(x, y, z));
          ASSERT_EQ(all[i], single);
          ASSERT_EQ(near[i], std::clamp(single, -0.3, 0.3));
        }
  }
}

TEST(DistanceOracle, LeavesOutWhatHasNoDistance) {
  const DistanceOracle oracle(withNaN(withZeroArea(withDuplicates(cube(1), 4), 3)));
  EXPECT_EQ(oracle.triangleCount(), 12u + 3u);
  for (const Vector3d& p : randomPoints(200, 1))
    ASSERT_NEAR(std::abs(oracle.signedDistance(p)), std::abs(boxDistance(p, {0.5, 0.5, 0.5})),
                1e-12);
  const DistanceOracle empty((TriangleMesh()));
  EXPECT_EQ(empty.signedDistance({0, 0, 0}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(empty.windingNumber({0, 0, 0}), 0);
}

}  // namespace
}  // namespace pelage::reference
