// Contacts of simulate_classic with spheres and tapered capsules, and what moves with its origin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "contact/contact_run.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

using reference::Pose;

Collider capsule(const Vector3d& head, double headRadius, const Vector3d& tail, double tailRadius,
                 double friction = 0) {
  return {toFloat4(head, headRadius),
          toFloat4(tail, tailRadius),
          toFloat4(head, friction),
          toFloat4(tail),
          {}};
}
Collider sphere(const Vector3d& center, double radius, double friction = 0) {
  return capsule(center, radius, center, radius, friction);
}

/// How deep the vertices behind the first two are in the union of the spheres between two ends [m];
/// negative outside.
double deepest(const HairAsset& asset, const std::vector<Float4>& positions,
               const Collider& shape) {
  const Vector3d head = toVector(shape.head), axis = toVector(shape.tail) - head;
  const double thinner = double{shape.tail.w} - double{shape.head.w}, length = axis.norm();
  double depth = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < positions.size(); ++i) {
    if (i % asset.verticesPerStrand < 2) continue;
    const Vector3d p = toVector(positions[i]) - head;
    // The depth is concave along the axis: its largest value is where the derivative is zero, or
    // at an end where it has none.
    double t = 0;
    if (length > std::abs(thinner)) {
      const double along = p.dot(axis) / length;
      const double away = std::sqrt(std::max(p.squaredNorm() - along * along, 0.0));
      const double slope = thinner / std::sqrt(length * length - thinner * thinner);
      t = std::clamp((along + away * slope) / length, 0.0, 1.0);
    } else {
      t = thinner > 0 ? 1 : 0;
    }
    keepLargest(depth, double{shape.head.w} + t * thinner - (p - t * axis).norm());
  }
  return depth;
}

/// Contacts have all the other axes, whose features are off here.
const StrandTerms kStill = StrandRun::terms(true, true, true, true, true);

class StrandContact : public GpuTest {};

// K6, K14: spheres, and capsules whose ends coincide or hold each other, keep hair out; lengths and
// tangents are those of the hair that was kept out.
TEST_P(StrandContact, KeepsHairOutOfEveryShapeAndAtItsLength) {
  const HairAsset asset = combAsset(9, 24, Vector3d(1, 0, 0));
  const std::vector<Collider> shapes = {sphere({0.1, -0.1, 0.04}, 0.08),
                                        capsule({0.1, -0.1, -0.2}, 0.08, {0.1, -0.1, 0.3}, 0.08),
                                        capsule({0.1, -0.1, -0.1}, 0.09, {0.1, -0.1, 0.2}, 0.05),
                                        // The tail lies inside the head.
                                        capsule({0.1, -0.1, 0.04}, 0.08, {0.11, -0.1, 0.04}, 0.02),
                                        capsule({0.1, -0.1, 0.04}, 0.02, {0.11, -0.1, 0.04}, 0.08)};
  for (const Collider& shape : shapes) {
    for (const float friction : {0.0f, 0.4f}) {
      StrandRun run(gpu(), asset);
      run.reset(bindPoses(asset));
      Collider collider = shape;
      collider.headBefore.w = friction;
      run.setColliders({collider});
      run.constants.gravity = {0, -9.81f, 0, 0};
      run.constants.dampingKeep = 0.94f;
      double depth = -1;
      for (int part = 0; part < 9; ++part) {
        for (int step = 0; step < 10; ++step) run.simulate(kStill);
        run.run();
        const std::vector<Float4> positions = run.positions(), tangents = run.tangents();
        keepLargest(depth, deepest(asset, positions, collider));
        EXPECT_LT(maxStretch(asset, positions, 1), 1e-5);
        for (size_t i = 0; i < positions.size(); ++i) {
          const size_t v = i % 24;
          if (v == 0 || v == 23) continue;
          const Vector3d along = toVector(positions[i + 1]) - toVector(positions[i - 1]);
          EXPECT_LT((toVector(tangents[i]) - along.normalized()).norm(), 2e-5) << i;
        }
      }
      EXPECT_LT(depth, 1e-3);
      // Without the contact the depth would be some centimetres; without touching it, negative.
      EXPECT_GT(depth, -1e-5);
      run.checkGuards();
    }
  }
}

// The force of a record goes on, friction in the tangent plane of now.
TEST_P(StrandContact, FrictionGoesOnInTheNewTangentPlane) {
  const HairAsset asset = combAsset(3, 24, Vector3d(1, 0, 0));
  StrandRun run(gpu(), asset);
  run.reset(bindPoses(asset));
  run.constants.gravity = {0, -9.81f, 0, 0};
  run.setColliders({sphere({0.1, -0.05, 0.02}, 0.08, 0.3)});
  for (int step = 0; step < 20; ++step) run.simulate(kStill);
  run.run();
  std::vector<ContactRecord> before = run.contactRecords();
  for (ContactRecord& record : before) record.force = {0.3f, -0.2f, 0.5f, 2.0f};
  run.setContactRecords(before);
  run.setColliders({sphere({0.1, -0.05, 0.03}, 0.08, 0.3)});
  run.simulate(kStill);
  run.run();
  const std::vector<ContactRecord> now = run.contactRecords();
  size_t wentOn = 0;
  for (size_t i = 0; i < now.size(); i += 2) {
    const Vector3d normal = toVector(now[i].plane), force = toVector(now[i].force);
    if (force == toVector(before[i].force) || now[i].force.w == 0) continue;
    const Vector3d old = toVector(before[i].force);
    EXPECT_LT((force - (old - normal * normal.dot(old))).norm(), 1e-6) << i;
    EXPECT_EQ(now[i].force.w, 2);
    ++wentOn;
  }
  EXPECT_GT(wentOn, 0u);
}

/// A vertex on the ridge of a capsule that is inclined by `degrees`: it hangs 500 m to the side, so
/// that its strand holds it there and nowhere else. Returns how far it slides down [m].
double slideOnSlope(Gpu& gpu, double degrees, float friction, int steps) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vector3d down(std::cos(angle), -std::sin(angle), 0);
  const HairAsset asset = vertexOnALongStrand();
  StrandRun run(gpu, asset);
  run.reset(bindPoses(asset));
  const Vector3d normal(std::sin(angle), std::cos(angle), 0);
  run.setColliders({capsule(-0.1 * normal - 4 * down, 0.1, -0.1 * normal + 4 * down, 0.1,
                            static_cast<double>(friction))});
  run.constants.gravity = {0, -9.81f, 0, 0};
  for (int step = 0; step < steps; ++step) run.simulate(kStill);
  run.run();
  const Vector3d end = toVector(run.positions()[2]);
  EXPECT_LT(std::abs(end.dot(normal)), 1e-3) << "off the slope";
  return end.dot(down);
}

// K14, K29
TEST_P(StrandContact, HoldsOnASlopeThatFrictionHolds) {
  EXPECT_LT(std::abs(slideOnSlope(gpu(), 10, 0.3f, 600)), 1e-3);
}

// K29
TEST_P(StrandContact, SlidesDownASteeperSlopeAsCoulombSays) {
  for (const float friction : {0.0f, 0.3f}) {
    const double angle = 25 * std::numbers::pi / 180;
    const double acceleration =
        kGravity * (std::sin(angle) - static_cast<double>(friction) * std::cos(angle));
    // 60 steps of x += h v, v += h a.
    const double expected = acceleration / 3600 * 60 * 61 / 2;
    const double displacement = slideOnSlope(gpu(), 25, friction, 60);
    EXPECT_NEAR(displacement, expected, 0.02 * expected) << friction;
  }
}

TEST_P(StrandContact, IsTakenAlongByASurfaceThatMovesUnderIt) {
  const HairAsset asset = vertexOnALongStrand();
  StrandRun run(gpu(), asset);
  run.reset(bindPoses(asset));
  run.constants.gravity = {0, -9.81f, 0, 0};
  const double displacement = 0.005;
  for (int step = 0; step < 40; ++step) {
    Collider belt = capsule({-4, -0.1, 0}, 0.1, {4, -0.1, 0}, 0.1, 0.5);
    belt.headBefore.x -= static_cast<float>(displacement);
    belt.tailBefore.x -= static_cast<float>(displacement);
    run.setColliders({belt});
    run.simulate(kStill);
    run.run();
  }
  // It first gains the belt's speed: v^2 / (2 mu g) behind.
  const double speed = displacement * 60;
  EXPECT_NEAR(run.positions()[2].x, 40 * displacement - speed * speed / (2 * 0.5 * kGravity),
              0.004);
}

TEST_P(StrandContact, SkipsCollidersThatAreNotFinite) {
  const HairAsset asset = combAsset(3, 12, Vector3d(1, 0, 0));
  const auto settled = [&](const std::vector<Collider>& colliders) {
    StrandRun run(gpu(), asset);
    run.reset(bindPoses(asset));
    run.setColliders(colliders);
    run.constants.gravity = {0, -9.81f, 0, 0};
    for (int step = 0; step < 20; ++step) run.simulate(kStill);
    run.run();
    return run.positions();
  };
  const Collider good = sphere({0.1, -0.1, 0.01}, 0.08, 0.3);
  Collider badHead = good, badTail = good, badBefore = good;
  badHead.head.w = kNan;
  badTail.tail.y = kInf;
  badBefore.headBefore.x = kNan;
  const std::vector<Float4> expected = settled({good});
  EXPECT_EQ(settled({badHead, badTail, good, badBefore}), expected);
  EXPECT_NE(settled({badHead, badTail, badBefore}), expected);
  for (const Float4& p : expected) EXPECT_TRUE(isFinite(p));
}

// The state is relative to the origin: far from it nothing is lost, and a new origin changes
// nothing.
TEST_P(StrandContact, DoesNotDependOnWhereTheOriginIs) {
  const HairAsset asset = wavyAsset(7, 16, 5);
  const Vector3d shift(2, -1, 3);
  const auto simulated = [&](bool rebase) {
    StrandRun run(gpu(), asset);
    std::vector<Pose> roots = bindPoses(asset);
    run.reset(roots);
    run.constants.gravity = {0, -9.81f, 0, 0};
    run.constants.localStiffness = 0.5f;
    run.constants.vspCoefficient = 0.5f;
    for (int step = 0; step < 20; ++step) {
      std::vector<Pose> now = roots;
      for (Pose& pose : now) pose.position.x() += 0.01;
      if (rebase && step == 10) {
        for (Pose& pose : roots) pose.position -= shift;
        for (Pose& pose : now) pose.position -= shift;
        run.constants.origin = toFloat4(shift);
        run.constants.rebase = toFloat4(-shift);
        run.constants.flags = 2;
      }
      run.setRoots(now, roots);
      run.simulate(StrandRun::terms(false, false, true, true));
      run.run();
      run.constants.flags = 0;
      roots = now;
    }
    return run.positions();
  };
  const std::vector<Float4> expected = simulated(false), moved = simulated(true);
  for (size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT((toVector(moved[i]) - toVector(expected[i])).norm(), 2e-5) << i;
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(Apis, StrandContact, testing::ValuesIn(kApis), apiTestName);

}  // namespace pelage::test
