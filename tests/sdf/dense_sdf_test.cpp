// SDFs that an engine has in a grid of its own: hair collides with them as with a mesh or a sphere.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "stress/stress_run.h"
#include "support/engine_buffer.h"
#include "support/not_numbers.h"
#include "support/plain_asset.h"

namespace pelage::test {
namespace {

constexpr double kGridBallRadius = 0.1;
constexpr float kGridCell = 0.01f;

/// The distance from a sphere on the nodes of a grid.
class SphereGrid {
 public:
  SphereGrid(SceneRun& run, const Vector3d& center, uint32_t first = 0)
      : buffer_(run, "distances", first + kNodes * kNodes * kNodes), center_(center) {
    sdf.distances = buffer_.id();
    sdf.first = first;
    sdf.grid.cellSize = kGridCell;
    sdf.grid.nodes = {kNodes, kNodes, kNodes};
    moveTo(center);
  }
  void moveTo(const Vector3d& center) {
    center_ = center;
    const double half = 0.5 * kGridCell * (kNodes - 1) + 0.003;
    sdf.grid.origin = toFloat3(center - Vector3d(half, half, half));
    write([](const Vector3d&, float distance) { return distance; });
  }
  /// \param valueAt of a position and its distance
  template <class Value>
  void write(const Value& valueAt) {
    std::vector<float> floats(sdf.first, kNan);
    for (uint32_t i = 0; i < kNodes * kNodes * kNodes; ++i) {
      const Vector3d at(sdf.grid.origin.x + kGridCell * static_cast<float>(i % kNodes),
                        sdf.grid.origin.y + kGridCell * static_cast<float>(i / kNodes % kNodes),
                        sdf.grid.origin.z + kGridCell * static_cast<float>(i / kNodes / kNodes));
      floats.push_back(valueAt(at, static_cast<float>((at - center_).norm() - kGridBallRadius)));
    }
    buffer_.write(floats);
  }
  DenseSdf sdf;

 private:
  static constexpr uint32_t kNodes = 31;
  EngineBuffer buffer_;
  Vector3d center_;
};

/// Strands that hang over a sphere around the origin.
HairAsset strandsAbove() {
  Random random(3);
  double x = 0, z = 0;
  return strandsAt(48, 16, [&](uint32_t, uint32_t v) {
    if (v == 0) x = random.between(-0.07, 0.07), z = random.between(-0.07, 0.07);
    return toFloat3({x + 0.016 * v, 0.115, z});
  });
}

class DenseSdfTest : public SolverTest {
 protected:
  DenseSdfTest() : asset_(strandsAbove()) {}
  SdfCollider& add(const DenseSdf& sdf) {
    id_ = run_.add(sdf, {.name = "engine's"});
    return run_.scene.collider(id_);
  }
  /// How deep the deepest vertex is in a sphere, and how near the surface the nearest one is.
  static std::pair<double, double> depths(const std::vector<Float4>& positions,
                                          const Vector3d& center) {
    double deepest = -std::numeric_limits<double>::infinity(), nearest = 1e9;
    for (const Float4& p : positions) {
      const double distance = (toVector(p) - center).norm() - kGridBallRadius;
      keepLargest(deepest, -distance);
      keepSmallest(nearest, std::abs(distance));
    }
    return {deepest, nearest};
  }

  HairAsset asset_;
  ColliderId id_ = ColliderId::kInvalid;
};

TEST_P(DenseSdfTest, ASphereHoldsHairAsTheColliderOfItsShapeDoes) {
  SphereGrid grid(run_, {0, 0, 0}, 5);
  SdfCollider& collider = add(grid.sdf);
  collider.margin = 0.001f;
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_});
  HairObject& other = run_.add(asset_, {.name = "other", .settings = settings_});
  HairObject& free = run_.add(asset_, {.name = "free", .settings = settings_});
  other.usesMeshColliders = free.usesMeshColliders = false;
  const auto radius = static_cast<float>(kGridBallRadius) + collider.margin;
  const CapsuleCollider sphere = {.headRadius = radius, .tailRadius = radius};
  setCollider(other, sphere);
  for (int frame = 0; frame < 90; ++frame) run_.step();
  const auto [deepest, nearest] = depths(run_.positions(hair), {0, 0, 0});
  const auto [deepestOfSphere, nearestOfSphere] = depths(run_.positions(other), {0, 0, 0});
  // The trilinear distance of a sphere is off by up to cell^2 / (4 radius) here: 2.5e-4 m.
  EXPECT_LT(deepest, deepestOfSphere + 5e-4) << "the sphere: " << deepestOfSphere;
  EXPECT_LT(nearest, 2e-3) << "it lies on the surface";
  EXPECT_GT(depths(run_.positions(free), {0, 0, 0}).first, 0.03) << "without it hair falls through";
  // Both come to rest alike.
  const auto a = run_.positions(hair), b = run_.positions(other);
  double mean = 0;
  for (size_t i = 0; i < a.size(); ++i)
    mean += distance(a[i], b[i]) / static_cast<double>(a.size());
  EXPECT_LT(mean, 5e-3);
}

TEST_P(DenseSdfTest, HairInsideComesOut) {
  SphereGrid grid(run_, {0, 0.03, 0});
  add(grid.sdf);
  HairAsset asset = asset_;
  settings_.gravity = {};
  HairObject& hair = run_.add(asset, {.name = "hair", .settings = settings_});
  const Vector3d center(0, 0.03, 0);
  run_.step();
  for (int frame = 0; frame < 60; ++frame) run_.step();
  double deepest = 0;
  const auto p = run_.positions(hair);
  ASSERT_TRUE(allFinite(p));
  for (size_t i = 0; i < p.size(); ++i) {
    if (i % 16 < 3) continue;  // held, and next to them
    keepLargest(deepest, kGridBallRadius - (toVector(p[i]) - center).norm());
  }
  EXPECT_LT(deepest, 2e-3);
}

TEST_P(DenseSdfTest, HairFollowsAGridThatMoves) {
  SphereGrid grid(run_, {0, -0.2, 0});
  SdfCollider& collider = add(grid.sdf);
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_});
  Vector3d center(0, -0.2, 0);
  for (int frame = 0; frame < 60; ++frame) {
    center.y() = -0.2 + 0.003 * std::min(frame, 40);
    grid.moveTo(center);
    collider.setDistances(grid.sdf);
    run_.step();
    EXPECT_EQ(countPasses(run_.list(), "import_sdf"), 1u) << "frame " << frame;
  }
  EXPECT_EQ(collider.grid(), grid.sdf.grid);
  EXPECT_LT(depths(run_.positions(hair), center).first, 3e-3);
  run_.step();
  EXPECT_EQ(countPasses(run_.list(), "import_sdf"), 0u) << "nothing has changed";
}

TEST_P(DenseSdfTest, FollowHairsAreHeldToo) {
  const std::vector<FollowHair> follows =
      valueOf(asset_.generateFollowHairs({.countPerGuide = 2, .maxRadius = 0.01f}));
  SphereGrid grid(run_, {0, 0, 0});
  add(grid.sdf);
  HairObject& hair = run_.add(asset_, {.name = "hair",
                                       .settings = settings_,
                                       .followHairs = follows,
                                       .collidingHair = CollidingHair::kGuidesAndFollows});
  for (int frame = 0; frame < 60; ++frame) run_.step();
  const auto p = run_.positions(hair);
  ASSERT_EQ(p.size(), 3 * asset_.positions.size());
  EXPECT_LT(depths(p, {0, 0, 0}).first, 4e-3);
}

TEST_P(DenseSdfTest, ShiftsOfTheWorldMoveIt) {
  SphereGrid grid(run_, {0, 0, 0});
  SdfCollider& collider = add(grid.sdf);
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_});
  for (int frame = 0; frame < 40; ++frame) run_.step();
  const Float3 origin = collider.grid().origin;
  expectOk(run_.scene.shiftOrigin({8, 0, -4}));
  EXPECT_FLOAT_EQ(collider.grid().origin.x, origin.x - 8);
  for (int frame = 0; frame < 20; ++frame) run_.step();
  EXPECT_LT(depths(run_.positions(hair), {-8, 0, 4}).first, 1e-3);
  expectOk(run_.scene.shiftOrigin({-8, 0, 4}));
}

TEST_P(DenseSdfTest, DistancesThatAreNoNumberAreFarOutside) {
  SphereGrid grid(run_, {0, 0, 0});
  HairObject& hair = run_.add(asset_, {.name = "hair", .settings = settings_});
  SdfCollider& collider = add(grid.sdf);
  // Nothing is known of more than the sphere's lower half.
  const auto endsWith = [&](float unknown) {
    grid.write(
        [&](const Vector3d& at, float distance) { return at.y() < 0.02 ? unknown : distance; });
    collider.setDistances(grid.sdf);
    hair.reset();
    for (int frame = 0; frame < 20; ++frame) run_.step();
    return run_.positions(hair);
  };
  // Four cells, which are as far as distances are told apart finely.
  const std::vector<Float4> outside = endsWith(4 * kGridCell);
  ASSERT_TRUE(allFinite(outside));
  const double deepest = depths(outside, {0, 0, 0}).first;
  EXPECT_GT(deepest, 0.02) << "hair falls in";
  for (const float unknown : {kNan, kInf, -kInf, -1e30f}) {
    const std::vector<Float4> ended = endsWith(unknown);
    ASSERT_EQ(ended.size(), outside.size());
    const double off = maxDistance(ended, outside);
    EXPECT_LT(off, 1e-5) << unknown;
  }
}

// Scene::drawCollider(): the disc of the sphere, wherever the grid and the world's origin are.
TEST_P(DenseSdfTest, IsDrawnWhereItIs) {
  if (std::get<1>(GetParam()) != Solver::kExact) GTEST_SKIP() << "solvers draw nothing";
  SphereGrid grid(run_, {0, 0, 0}, 3);
  SdfCollider& collider = add(grid.sdf);
  run_.add(asset_, {.name = "hair", .settings = settings_});
  // How many pixels are covered, and where their mean is [pixels].
  const auto drawn = [&](const Vector3d& eye) {
    run_.step();
    PassList list;
    expectOk(run_.scene.drawCollider(id_, SceneRun::viewFrom(toFloat3(eye), 100), {}, {}, list));
    const RenderedImage image = run_.render(list, 100);
    Vector3d sum(0, 0, 0);
    for (size_t i = 0; i < image.pixels.size(); ++i)
      if (image.pixels[i].w > 0.5f)
        sum += Vector3d(static_cast<double>(i % 100), static_cast<double>(i / 100), 1);
    const auto counts = run_.device()->read(collider.buffers().isoCounts);
    EXPECT_TRUE(counts);
    if (counts) expectOk(run_.scene.checkColliderDraw(id_, *counts));
    return Vector3d(sum.x() / sum.z(), sum.y() / sum.z(), sum.z());
  };
  // Seen from 0.5 m, 1 / sqrt(24) of the distance is its radius, and 100 pixels are 0.828 of it.
  const double pixels = 3.14159265 * std::pow(100 / 0.828 / std::sqrt(24.0), 2);
  const auto expectDisc = [&](const Vector3d& seen, double x, double y, const char* when) {
    EXPECT_NEAR(seen.z(), pixels, 0.04 * pixels) << when;
    EXPECT_NEAR(seen.x(), x, 1) << when;
    EXPECT_NEAR(seen.y(), y, 1) << when;
  };
  expectDisc(drawn({0, 0, 0.5}), 49.5, 49.5, "in the middle");
  grid.moveTo({0.05, 0.025, 0});
  collider.setDistances(grid.sdf);
  expectDisc(drawn({0, 0, 0.5}), 49.5 + 12.1, 49.5 - 6.0, "moved");
  expectOk(run_.scene.shiftOrigin({-8, 0, 4.5f}));
  expectDisc(drawn({8.05, 0.025, -4}), 49.5, 49.5, "in a world whose origin is elsewhere");
  expectOk(run_.scene.shiftOrigin({8, 0, -4.5f}));
}

INSTANTIATE_TEST_SUITE_P(Apis, DenseSdfTest, testing::ValuesIn(solversOnApis()), solverTestName);

// ---- without a device

TEST(DenseSdfList, WhatIsWrongIsNamed) {
  Scene scene;
  const BufferId buffer = scene.resources().add({.name = "distances", .size = 32, .stride = 4});
  const DenseSdf good = {.distances = buffer, .grid = {.cellSize = 0.1f, .nodes = {2, 2, 2}}};
  const auto expectRefused = [&](const DenseSdf& sdf, const char* what) {
    expectError(scene.addCollider(sdf, {.name = "ground"}), {"collider 'ground': ", what});
  };
  DenseSdf bad = good;
  bad.grid.origin.z = kNan;
  expectRefused(bad, "origin of its grid is not finite");
  bad = good;
  bad.grid.cellSize = 0;
  expectRefused(bad, "cells of its grid");
  bad = good;
  bad.grid.nodes = {2, 2, 1};
  expectRefused(bad, "2 x 2 x 1 nodes");
  bad = good;
  bad.grid.nodes = {100000, 100000, 2};
  expectRefused(bad, "takes 2^28 in all");
  bad = good;
  bad.grid.nodes = {2, 2, 3};
  expectRefused(bad, "has 32 bytes; 2 x 2 x 3 nodes take 48");
  bad = good;
  bad.first = 1;
  expectRefused(bad, "take 36");
  const Result<ColliderId> id = required(scene.addCollider(good, {.name = "ground"}));
  ASSERT_TRUE(scene.addHair(makeAsset(), {}));
  PassList list;
  EXPECT_TRUE(scene.simulate(1.0f / 60, list));
  EXPECT_EQ(countPasses(list, "import_sdf"), 1u);
  bad = good;
  bad.grid.nodes = {2, 4, 1};
  scene.collider(*id).setDistances(bad);
  expectError(scene.simulate(1.0f / 60, list), "collider 'ground'");
  scene.collider(*id).setDistances(good);
  EXPECT_TRUE(scene.simulate(1.0f / 60, list));
  EXPECT_FALSE(scene.copySdf(*id, {}, {}));
}

}  // namespace
}  // namespace pelage::test
