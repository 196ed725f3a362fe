// Shadow maps of point and spot lights: what hair lets through, against closed forms and the
// double-precision reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference/shadow/shadow_map_reference.h"
#include "shading/light_numbers.h"
#include "shadow/strand_shadow_run.h"
#include "support/extremes.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

class PointShadow : public GpuTest {};

/// Fibers along x in layers of 0.6 x 0.6 m, turned so that z becomes an axis of the world.
struct Slab {
  static constexpr double kGap = 1e-3, kHalf = 0.3, kThickness = 0.01;
  static constexpr uint32_t kLayers = 10;
  static constexpr double kRadius = 80e-6, kOpacity = 0.9;
  double distance = 0;  // of its first layer along z
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();

  Hair hair() const {
    Hair result;
    result.radius = static_cast<float>(kRadius);
    result.opacity = static_cast<float>(kOpacity);
    const int count = static_cast<int>(2 * kHalf / kGap);
    for (uint32_t layer = 0; layer < kLayers; ++layer) {
      const double z = distance - kThickness * layer / (kLayers - 1);
      for (int i = 0; i < count; ++i) {
        const double y = -kHalf + kGap * (i + (layer + 0.5) / kLayers);
        for (const double x : {-kHalf, kHalf})
          result.positions.push_back(toFloat4(turn * Vector3d(x, y, z)));
      }
    }
    return result;
  }
  /// Transmittance of all layers along a ray: a cylinder along x shades a strip of a plane z whose
  /// width grows with the slope in y alone.
  double transmittance(const Vector3d& ray) const {
    const Vector3d d = turn.transpose() * ray;
    const double width = 2 * kRadius * std::hypot(d.y(), d.z()) / std::abs(d.z());
    return std::exp(-kOpacity * kLayers * width / kGap);
  }
};

StrandShadowDef slabDef(const Vector3d& light) {
  StrandShadowDef def;
  def.hasPosition = true;
  def.position = floatsOf(light);
  def.radius = 0.45f;
  def.size = 256;
  def.layerRange = 0.04f;
  def.firstWord = 64;
  return def;
}

/// Largest difference to the closed form at these points.
double worstError(Gpu& gpu, const Slab& slab, const StrandShadowDef& def,
                  const std::vector<Float4>& points) {
  const Hair hair = slab.hair();
  MapRun run(gpu, planFor(def, {hair.shadowed()}));
  run.draw(hair);
  const std::vector<float> seen = run.transmittance(points);
  const Vector3d light = vectorOf(def.position), toLight = vectorOf(def.toLight);
  double worst = 0;
  for (size_t i = 0; i < seen.size(); ++i) {
    const Vector3d ray = def.hasPosition ? Vector3d(light - toVector(points[i])) : toLight;
    keepLargest(worst, std::abs(static_cast<double>(seen[i]) - slab.transmittance(ray)));
  }
  return worst;
}

std::vector<Float4> pointsBehind(double range, double z) {
  std::vector<Float4> points;
  Random random(4);
  for (int i = 0; i < 400; ++i)
    points.push_back(toFloat4({random.between(-range, range), random.between(-range, range), z}));
  return points;
}

// A layer lets exp(-area) of the light through; what a map adds is that the 1 mm between fibers do
// not divide its texels of 3.5 mm evenly.
constexpr double kSlabTolerance = 0.01;

TEST_P(PointShadow, SlabTransmitsAsMuchFromAnyDistance) {
  const Slab slab;
  const std::vector<Float4> points = pointsBehind(0.12, -0.1);
  StrandShadowDef parallel = slabDef({0, 0, 0});
  parallel.hasPosition = false;
  parallel.toLight = {0, 0, 1};
  EXPECT_LT(worstError(gpu(), slab, parallel, points), kSlabTolerance);
  // Far away it is a parallel light; 0.5 m are within reach of the ball, and need a cube.
  for (const double distance : {50.0, 3.0, 0.9, 0.5}) {
    const StrandShadowDef def = slabDef({0.1, -0.05, distance});
    EXPECT_EQ(planFor(def, {}).view.faceCount, distance < 0.7 ? 6u : 1u);
    EXPECT_LT(worstError(gpu(), slab, def, points), kSlabTolerance) << distance << " m";
  }
  // From the side fibers hide more of each other in one direction than in the other.
  for (const Vector3d& light : {Vector3d(2, 0, 2), Vector3d(0, 2, 2)})
    EXPECT_LT(worstError(gpu(), slab, slabDef(light), pointsBehind(0.05, -0.05)), kSlabTolerance);
}

TEST_P(PointShadow, SpotLightHasTheShadowOfAPointLight) {
  StrandShadowDef def = slabDef({0.02, 0.03, 0.5});
  def.toLight = {0, 0, 1};
  // Texels of 3 mm and more: smaller ones resolve the fibers where their layers line up.
  def.size = 64;
  for (const float cone : {0.2f, 0.35f, 0.9f}) {
    def.coneAngle = cone;
    EXPECT_EQ(planFor(def, {}).view.faceCount, 1u);
    // 0.6 m in front of it.
    const double range = 0.6 * std::tan(static_cast<double>(cone)) / 1.5 - 0.03;
    EXPECT_LT(worstError(gpu(), Slab(), def, pointsBehind(std::min(range, 0.2), -0.1)),
              kSlabTolerance)
        << cone;
  }
}

TEST_P(PointShadow, CubeHasNoSeamsAroundALightInTheHair) {
  // On each side, with rays that pass from one face into its neighbors.
  const Vector3d light(0.01, -0.02, 0.015);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Slab slab;
      slab.distance = -0.1;
      slab.turn.setZero();
      slab.turn((axis + 1) % 3, 0) = 1;
      slab.turn((axis + 2) % 3, 1) = side;
      slab.turn(axis, 2) = side;
      std::vector<Float4> points;
      for (int i = -20; i <= 20; ++i)
        for (int j = -20; j <= 20; ++j)
          points.push_back(toFloat4(slab.turn * Vector3d(0.0171 * i, 0.0171 * j, -0.22)));
      const StrandShadowDef def = slabDef(light);
      EXPECT_EQ(planFor(def, {}).view.faceCount, 6u);
      // Texels of 1.6 mm, between fibers that are 1 mm apart in a layer.
      EXPECT_LT(worstError(gpu(), slab, def, points), 0.025) << "axis " << axis << ", " << side;
    }
  }
}

reference::ShadowProjection faceOf(const StrandShadowView& view, const Vector3d& light,
                                   uint32_t face) {
  reference::ShadowProjection p;
  p.width = view.width;
  p.height = view.height;
  p.texelSize = static_cast<double>(view.texelSize);
  p.light = light;
  p.x = rowOf(view.mapX);
  p.y = rowOf(view.mapY);
  p.z = rowOf(view.mapZ);
  p.w = rowOf(view.mapW);
  if (view.faceCount == 6) {
    const Eigen::Vector4d offsets[3] = {p.x, p.y, p.w};
    const uint32_t axis = face / 2;
    p.w = offsets[axis] * (face % 2 == 0 ? 1 : -1);
    p.x = offsets[(axis + 1) % 3] / p.texelSize + 0.5 * view.width * p.w;
    p.y = offsets[(axis + 2) % 3] / p.texelSize + 0.5 * view.width * p.w;
    p.z = p.w - Eigen::Vector4d(0, 0, 0, static_cast<double>(view.nearW));
  }
  return p;
}

// Rounding of positions on the map (2^-16 texels) moves a part of a fiber here and there into a
// neighboring layer.
TEST_P(PointShadow, CurledHairIsInTheMapAsInTheReference) {
  const Hair hair = headOfHair(1200, 12);
  const std::vector<ShadowFiber> fibers = hair.fibers();
  for (const Vector3d& light : {Vector3d(0.3, 0.6, 0.4), Vector3d(0.06, 0.11, 0.03)}) {
    for (const uint32_t layers : {0u, 8u}) {
      StrandShadowDef def = headDef(128, layers);
      def.hasPosition = true;
      def.position = floatsOf(light);
      const StrandShadowPlan plan = planFor(def, {hair.shadowed()});
      const StrandShadowView& view = plan.view;
      const Vector3d at = vectorOf(def.position);
      std::vector<reference::ShadowMapReference> faces;
      for (uint32_t face = 0; face < view.faceCount; ++face)
        faces.emplace_back(faceOf(view, at, face), fibers);
      std::vector<Float4> points;
      for (size_t i = 5; i < hair.positions.size(); i += 29) points.push_back(hair.positions[i]);
      MapRun run(gpu(), plan);
      run.draw(hair);
      const std::vector<float> seen = run.transmittance(points);
      const reference::ShadowReading reading = {layers, static_cast<double>(view.layerRange),
                                                static_cast<double>(view.bias),
                                                static_cast<double>(view.extinction)};
      double worst = 0, least = 1;
      size_t moved = 0;
      for (size_t i = 0; i < points.size(); ++i) {
        const Vector3d offset = toVector(points[i]) - at;
        int axis = 0;
        offset.cwiseAbs().maxCoeff(&axis);
        const size_t face =
            view.faceCount == 1 ? 0 : static_cast<size_t>(2 * axis + (offset[axis] < 0 ? 1 : 0));
        const double expected = faces[face].light(toVector(points[i]), reading);
        const double error = std::abs(static_cast<double>(seen[i]) - expected);
        keepLargest(worst, error);
        moved += error > 2e-4 ? 1 : 0;
        least = std::min(least, expected);
      }
      EXPECT_LT(moved, points.size() / 100) << layers << " layers, " << view.faceCount << " faces";
      EXPECT_LT(worst, 5e-3) << layers << " layers, " << view.faceCount << " faces";
      EXPECT_LT(least, 0.5);
      RecordProperty("worst" + std::to_string(layers) + "_" + std::to_string(view.faceCount),
                     std::to_string(worst));
    }
  }
}

TEST_P(PointShadow, NothingOfBadHairLeavesTheMapOrTheRange) {
  Hair hair;
  for (const float bad : {kNan, kInf, -kInf, 1e38f, -1e30f, 0.0f, 1e-30f})
    for (const float other : {0.02f, -0.05f, 1e20f}) {
      hair.positions.push_back({bad, other, 0.05f, 0});
      hair.positions.push_back({other, bad, -0.01f, 0});
    }
  // Through the light, at it, and past it.
  hair.positions.insert(hair.positions.end(), {{-1, 0, 0, 0},
                                               {1, 0, 0, 0},
                                               {0, 0, 0, 0},
                                               {0, 0, 0, 0},
                                               {-1e6f, 0.01f, 0, 0},
                                               {1e6f, 0.02f, 0.01f, 0}});
  std::vector<Float4> points = hair.positions;
  for (int i = -40; i <= 40; ++i) points.push_back({0.01f * static_cast<float>(i), 0.03f, 0, 0});
  for (const uint32_t layers : {0u, 4u}) {
    StrandShadowDef def = headDef(32, layers);
    def.hasPosition = true;
    ShadowedHair known = hair.shadowed();
    known.strandLength = 0.1f;
    known.volume = 0;
    const StrandShadowPlan plan = planFor(def, {known});
    EXPECT_EQ(plan.view.faceCount, 6u);
    MapRun run(gpu(), plan);
    run.draw(hair);
    const MapWords map = run.map();
    for (size_t i = 0; i < map.count(); ++i)
      EXPECT_TRUE(!map.hasHair(i) || map.nearest(i) < 0x7f800000u);
    for (const float t : run.transmittance(points)) EXPECT_TRUE(t >= 0 && t <= 1) << t;
  }
}

// Cut at the near plane, so that a strand does not vanish where it passes the light.
TEST_P(PointShadow, StrandThatPassesTheLightIsCutAtTheNearPlane) {
  Hair hair;
  hair.radius = 100e-6f;
  hair.positions = {{-0.3f, 0.02f, 0.012f, 0}, {0.3f, 0.02f, 0.012f, 0}};
  StrandShadowDef def = slabDef({0, 0, 0});
  def.size = 128;
  const StrandShadowPlan plan = planFor(def, {hair.shadowed()});
  EXPECT_EQ(plan.view.faceCount, 6u);
  MapRun run(gpu(), plan);
  run.draw(hair);
  // On rays through its middle, and to both sides.
  for (const float x : {0.0f, 0.015f, 0.1f, -0.1f, -0.25f}) {
    const std::vector<float> seen =
        run.transmittance({{x * 1.5f, 0.03f, 0.018f, 0}, {x * 0.8f, 0.016f, 0.0096f, 0}});
    EXPECT_LT(seen[0], 0.985f) << x;
    EXPECT_EQ(seen[1], 1) << x;
  }
}

TEST(PointShadowPlan, TexelsStayInPlaceWhenTheBallMovesALittle) {
  StrandShadowDef def = headDef(512, 4);
  def.hasPosition = true;
  def.position = {0.5f, 1.0f, 0.7f};
  const StrandShadowPlan still = planFor(def, {});
  int moved = 0;
  for (int i = 0; i < 100; ++i) {
    def.center.x += 0.00037f;
    def.center.z -= 0.00021f;
    const StrandShadowPlan plan = planFor(def, {});
    moved += plan.view.mapX == still.view.mapX && plan.view.mapY == still.view.mapY ? 0 : 1;
    // The ball is in the map, with a texel around, and behind the near plane.
    const auto& v = plan.view;
    Random random(9);
    for (int k = 0; k < 20; ++k) {
      const Vector3d p = toVector({def.center.x, def.center.y, def.center.z, 0}) +
                         random.vector(1).normalized() * static_cast<double>(def.radius);
      const auto at = [&](const Float4& row) {
        return toVector(row).dot(p) + static_cast<double>(row.w);
      };
      for (const Float4& row : {v.mapX, v.mapY}) {
        EXPECT_GT(at(row) / at(v.mapW), 1.4);
        EXPECT_LT(at(row) / at(v.mapW), 510.6);
      }
      EXPECT_GT(at(v.mapZ), 0);
      EXPECT_GE(at(v.mapW), static_cast<double>(v.nearW));
    }
  }
  EXPECT_EQ(moved, 0);
}

TEST(PointShadowPlan, SpotLightLooksAtTheNarrowerOfItsConeAndTheHair) {
  StrandShadowDef def = headDef(64, 4);
  def.hasPosition = true;
  def.position = {0, 2, 0};
  def.toLight = {0, 1, 0};
  const StrandShadowPlan around = planFor(def, {});
  def.coneAngle = 0.05f;
  const StrandShadowPlan narrow = planFor(def, {});
  EXPECT_NEAR(static_cast<double>(narrow.view.texelSize), 2 * std::tan(0.05) / 61, 1e-6);
  EXPECT_LT(narrow.view.texelSize, around.view.texelSize);
  def.coneAngle = 1;
  EXPECT_EQ(planFor(def, {}).view.texelSize, around.view.texelSize);
  // In the hair its cone has one map, unless it is too wide.
  def.position = {0, 0.1f, 0};
  EXPECT_EQ(planFor(def, {}).view.faceCount, 1u);
  def.coneAngle = 1.4f;
  EXPECT_EQ(planFor(def, {}).view.faceCount, 6u);

  def.position.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(detail::planStrandShadow(def, {}));
  def.position.x = 0;
  def.coneAngle = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(detail::planStrandShadow(def, {}));
}

// A light of 1 as it arrives at points.
std::vector<Float4> illumination(Gpu& gpu, const Light& light, const std::vector<Float4>& points) {
  const GuardedBuffer<Float4> pointBuffer(gpu, "litPoints", points);
  const GuardedBuffer<Float4> results(gpu, "litResults",
                                      std::vector<Float4>(points.size(), {-1, -1, -1, -1}));
  shadow_test::ReadIlluminationConstants constants = {};
  constants.litDirection = {0, 0, 0, 1};
  constants.litColor = {1, 1, 1, 0};
  constants.litCone = detail::coneOf(light, light.direction);
  constants.litCount = static_cast<uint32_t>(points.size());
  dispatch(gpu, shadow_test::readIlluminationVariant({}), points.size(), [&](PassBuilder& pass) {
    pointBuffer.bindTo(pass, "g_litPoints");
    results.bindTo(pass, "g_litResults");
    pass.constants("ReadIlluminationConstants", constants);
  });
  return results.read();
}

// glTF's KHR_lights_punctual, and the inverse square of the distance.
TEST_P(PointShadow, SpotLightEndsAtItsCone) {
  struct Cone {
    double inner, outer;
  };
  for (const auto& [inner, outer] :
       {Cone{0.3, 0.5}, Cone{0, 1.5}, Cone{0.085, 0.09}, Cone{0.01, 0.02}, Cone{0, 0.01}}) {
    Light light = {.hasPosition = true};
    light.direction = {0, 0, 1};
    std::vector<Float4> points;
    std::vector<double> expected, angles;
    light.innerConeAngle = static_cast<float>(inner);
    light.outerConeAngle = static_cast<float>(outer);
    const double range = std::cos(inner) - std::cos(outer);
    for (int i = 0; i <= 160; ++i) {
      const double angle = std::min(0.04 * outer * i, std::numbers::pi), distance = 0.5 + 0.01 * i;
      points.push_back(toFloat4(
          Vector3d(std::sin(angle) * 0.6, std::sin(angle) * 0.8, -std::cos(angle)) * distance));
      const double share = std::clamp((std::cos(angle) - std::cos(outer)) / range, 0.0, 1.0);
      expected.push_back(share * share / (distance * distance));
      angles.push_back(angle);
    }
    const std::vector<Float4> seen = illumination(gpu(), light, points);
    // A cosine of nearly 1 is rounded by 6e-8, and the difference of two of them is divided.
    const double rounding = 4e-7 / range;
    for (size_t i = 0; i < seen.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(seen[i].x), expected[i], 1e-4 + 8 * rounding)
          << angles[i] << " of " << outer;
      if (angles[i] > 1.01 * outer) {
        EXPECT_EQ(seen[i].x, 0) << angles[i] << " of " << outer;
      }
    }
  }
  // One without an edge between light and dark.
  Light light = {.hasPosition = true};
  light.direction = {0, 0, 1};
  light.innerConeAngle = light.outerConeAngle = 0.2f;
  const std::vector<Float4> seen =
      illumination(gpu(), light, {{0.19f, 0, -1, 0}, {0.21f, 0, -1, 0}});
  EXPECT_NEAR(seen[0].x, 1 / (1 + 0.19f * 0.19f), 1e-4f);
  EXPECT_EQ(seen[1].x, 0);
}

INSTANTIATE_TEST_SUITE_P(All, PointShadow, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
