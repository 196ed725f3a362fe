// Contact of whole strands in scenes: rest, energy, Coulomb's friction, penetration.
#include <gtest/gtest.h>

#include <numbers>

#include "contact/contact_run.h"
#include "support/not_numbers.h"
#include "support/scene_test.h"

namespace pelage::test {
namespace {

enum class ColliderShape : uint8_t { kCapsule, kMesh };

SimulationSettings settingsOf(float bendLength, float damping = 0.06f) {
  SimulationSettings s;
  s.bendLength = bendLength;
  s.damping = damping;
  s.vspCoefficient = 0;
  s.vspThreshold = kInf;
  return s;
}

class ContactScene : public SceneTestOn<std::tuple<Api, ColliderShape>> {
 protected:
  bool mesh() const { return std::get<1>(GetParam()) == ColliderShape::kMesh; }

  HairObject& addStrand(const std::vector<Point>& points, const SimulationSettings& s) {
    hair_ = &run_.add(strandAsset(points), {.settings = s});
    return *hair_;
  }
  /// A cylinder along z of 5 cm.
  void addCylinder(float friction) {
    if (!mesh()) {
      setCollider(*hair_, cylinder(0.05f, friction));
      return;
    }
    const ColliderId id = run_.add(cylinderMesh(0.05, 0.06, 256), {.cellSize = 0.004f});
    run_.scene.collider(id).friction = friction;
    run_.scene.collider(id).margin = 0;
  }
  void step() {
    run_.step();
    watch_.take(run_.positions(*hair_), 1.0 / 60);
  }
  double depth() const { return depthInCylinder(watch_.now, hair_->verticesPerStrand(), 0.05); }

  HairObject* hair_ = nullptr;
  Watch watch_;
};
class MeshContactScene : public ContactScene {};
class CapsuleContactScene : public ContactScene {};

/// Over the shoulder: 0.5 m of hair, straight beside the top of the cylinder.
std::vector<Point> overShoulder(int count) {
  return straight(count, {-0.07, 0.075, 0}, {0.43, 0.075, 0});
}

TEST_P(ContactScene, HairOverAShoulderComesToRestAndSleeps) {
  addStrand(overShoulder(48), settingsOf(0.0467f));
  addCylinder(0.3f);
  double deepest = -1;
  int resting = 0;
  for (int frame = 0; frame < 400; ++frame) {
    step();
    if (frame > 10) keepLargest(deepest, depth());
    resting = watch_.fastest() < 5e-4 ? resting + 1 : 0;
  }
  EXPECT_GT(resting, 60);
  EXPECT_LT(deepest, 1e-4);
  EXPECT_GT(deepest, -1e-3) << "nothing touched";
  EXPECT_LT(depth(), 5e-5);
  EXPECT_EQ(run_.awake(*hair_), 0u);
}

TEST_P(ContactScene, ALimpRopeOverAFrictionlessCylinderOnlyFalls) {
  addStrand(straight(64, {-0.07, 0.055, 0}, {0.43, 0.055, 0}), settingsOf(0, 0));
  addCylinder(0);
  double lowest = HUGE_VAL, rise = 0, deepest = -1;
  for (int frame = 0; frame < 15; ++frame) {
    step();
    const double height = watch_.height();
    keepLargest(rise, height - lowest);
    keepSmallest(lowest, height);
    keepLargest(deepest, depth());
    ASSERT_TRUE(std::isfinite(height));
  }
  EXPECT_LT(lowest, -0.02) << "it falls";
  EXPECT_LT(rise, 2e-4);
  EXPECT_LT(deepest, 5e-4);
}

/// Slides a limp strand that lies across a slope, whose angle is so many degrees above that of
/// friction. Returns how far its tip gets [m].
double slide(SceneRun& run, double friction, double degreesAbove, double seconds,
             uint32_t subSteps = 1) {
  const double angle = std::atan(friction) + degreesAbove * std::numbers::pi / 180;
  // The slope is level, and gravity is inclined.
  SimulationSettings s = settingsOf(0, 0);
  s.gravity = {static_cast<float>(kGravity * std::sin(angle)),
               static_cast<float>(-kGravity * std::cos(angle)), 0};
  s.subSteps = subSteps;
  HairObject& hair =
      run.add(strandAsset(straight(32, {0, 0, -0.25}, {0, 0, 0.25})), {.settings = s});
  const ColliderId id = run.add(slabMesh(0.4f, 0.1f), {.cellSize = 0.02f});
  run.scene.collider(id).friction = static_cast<float>(friction);
  run.scene.collider(id).margin = 0;
  // The first frame puts the strand there.
  run.step();
  if (friction > 0)
    for (int frame = 0; degreesAbove < 0 && frame < 10; ++frame) run.step();
  const double from = double{run.positions(hair).back().x};
  const int frames = static_cast<int>(std::lround(seconds * 60));
  for (int frame = 0; frame < frames; ++frame) run.step();
  const double slip = double{run.positions(hair).back().x} - from;
  run.clear();
  return slip;
}

TEST_P(MeshContactScene, FrictionHoldsBelowItsAngleAndDoesNotCreep) {
  for (const double friction : {0.1, 0.3, 0.6, 1.0})
    EXPECT_LT(std::abs(slide(run_, friction, -0.5, 1)), 1e-5) << friction;
  EXPECT_LT(std::abs(slide(run_, 0.3, -1, 10)), 1e-5);
}

TEST_P(MeshContactScene, HairSlidesAboveTheAngleOfFrictionAsCoulombSays) {
  for (const double friction : {0.0, 0.1, 0.3, 0.6, 1.0}) {
    const double angle = std::atan(friction) + 2 * std::numbers::pi / 180;
    // From the speed that it has after the first frame.
    const double acceleration = kGravity * (std::sin(angle) - friction * std::cos(angle));
    const double expected = acceleration * (0.5 * 0.3 * 0.3 + 0.3 / 60);
    EXPECT_NEAR(slide(run_, friction, 2, 0.3), expected, 0.03 * expected) << friction;
  }
}

TEST_P(ContactScene, ATautLimpStrandStaysOverTheCylinder) {
  constexpr double kCylinder = 0.05;
  std::vector<Point> points;
  const double first = std::sqrt(0.1 * 0.1 - kCylinder * kCylinder);
  const double at = std::atan2(0.06, -0.08) - std::acos(0.5), second = kCylinder * at;
  const double tx = kCylinder * std::cos(at), ty = kCylinder * std::sin(at);
  for (int i = 0; i < 64; ++i) {
    const double s = (first + second + 0.3) * i / 63;
    if (s < first) {
      points.push_back({-0.08 + (tx + 0.08) * s / first, 0.06 + (ty - 0.06) * s / first, 0});
    } else if (s < first + second) {
      const double angle = at - (s - first) / kCylinder;
      points.push_back({kCylinder * std::cos(angle), kCylinder * std::sin(angle), 0});
    } else {
      points.push_back({kCylinder, -(s - first - second), 0});
    }
  }
  SimulationSettings s = settingsOf(0);
  s.sleep.enabled = false;
  addStrand(points, s);
  addCylinder(0.3f);
  // It settles on the facets first, and takes up the slack of its edges.
  for (int frame = 0; frame < 60; ++frame) step();
  const Point settled = toPoint(watch_.now.back());
  EXPECT_LT(distance(settled, points.back()), 1e-3);
  double farthest = 0;
  for (int frame = 0; frame < 600; ++frame) {
    step();
    const double moved = distance(toPoint(watch_.now.back()), settled);
    if (!(moved <= farthest)) farthest = std::isfinite(moved) ? moved : HUGE_VAL;
  }
  EXPECT_LT(farthest, 5e-4);
}

TEST_P(CapsuleContactScene, ATurningDrumTakesHairAlong) {
  // Limp hair that winds along the top of the drum, so that it has slack, and is held at the root.
  const double speed = 1;
  std::vector<Point> points;
  for (int i = 0; i < 24; ++i) {
    const double x = i < 2 ? 0 : 0.008 * std::sin(i * 1.2);
    points.push_back({x, std::sqrt(0.0501 * 0.0501 - x * x), -0.06 + 0.003 * i});
  }
  addStrand(points, settingsOf(0));
  CapsuleCollider drum = cylinder(0.05f, 1.0f);
  drum.angularVelocity = {0, 0, static_cast<float>(-speed)};
  setCollider(*hair_, drum);
  const auto angleOfTip = [&] {
    const Float4& tip = watch_.now.back();
    return std::atan2(double{tip.x}, double{tip.y});
  };
  for (int frame = 0; frame < 3; ++frame) step();
  const double from = angleOfTip();
  const int frames = 12;
  for (int frame = 0; frame < frames; ++frame) step();
  const double angle = angleOfTip() - from;
  EXPECT_NEAR(angle, speed * frames / 60, 0.05 * speed * frames / 60);
}

TEST_P(CapsuleContactScene, HairThatIsThrownAtStopsAtTheSurface) {
  addStrand(straight(32, {0, 0, 0}, {0, -0.3, 0}), settingsOf(0.0467f));
  double deepest = -1;
  for (int frame = 0; frame < 30; ++frame) {
    const float x = -0.3f + 5.0f / 60 * static_cast<float>(frame);
    const Float3 center = {x, -0.2f, 0.01f};
    setCollider(*hair_, {.head = center,
                         .headRadius = 0.05f,
                         .tail = center,
                         .tailRadius = 0.05f,
                         .friction = 0.3f});
    step();
    for (size_t i = 2; i < watch_.now.size(); ++i)
      keepLargest(deepest, 0.05 - distance(toPoint(watch_.now[i]), {x, -0.2, 0.01}));
  }
  EXPECT_LT(deepest, 5e-5);
  EXPECT_GT(deepest, -3e-3) << "nothing touched";
}

std::string shapeTestName(const testing::TestParamInfo<std::tuple<Api, ColliderShape>>& info) {
  return std::string(apiName(std::get<0>(info.param))) +
         (std::get<1>(info.param) == ColliderShape::kMesh ? "Mesh" : "Capsule");
}

INSTANTIATE_TEST_SUITE_P(All, ContactScene,
                         testing::Combine(testing::ValuesIn(kRuntimeApis),
                                          testing::Values(ColliderShape::kCapsule,
                                                          ColliderShape::kMesh)),
                         shapeTestName);
INSTANTIATE_TEST_SUITE_P(All, MeshContactScene,
                         testing::Combine(testing::ValuesIn(kRuntimeApis),
                                          testing::Values(ColliderShape::kMesh)),
                         shapeTestName);
INSTANTIATE_TEST_SUITE_P(All, CapsuleContactScene,
                         testing::Combine(testing::ValuesIn(kRuntimeApis),
                                          testing::Values(ColliderShape::kCapsule)),
                         shapeTestName);

}  // namespace
}  // namespace pelage::test
