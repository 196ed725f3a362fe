// Shadow maps of strands: what they hold, and what receivers see, against the double-precision
// reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference/shadow/shadow_map_reference.h"
#include "shadow/strand_shadow_run.h"
#include "support/extremes.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

class StrandShadow : public GpuTest {};

TEST_P(StrandShadow, MapHoldsTheAreaThatFibersCover) {
  struct Case {
    uint32_t vertices, size, layers;
    bool thick;
  };
  for (const Case c : {Case{12, 256, 8, false}, Case{12, 32, 16, true}, Case{2, 256, 1, false}}) {
    SCOPED_TRACE(testing::Message() << c.vertices << " vertices, " << c.size << " texels");
    Hair hair = headOfHair(1500, c.vertices);
    if (c.thick) {
      Random random(5);
      for (uint32_t s = 0; s < hair.strands(); ++s)
        hair.thickness.push_back(static_cast<float>(random.between(0, 2)));
    }
    const StrandShadowPlan plan = planFor(headDef(c.size, c.layers), {hair.shadowed()});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const double area = reference::coveredArea(hair.fibers(), axesOf(plan.view));
    EXPECT_NEAR(run.sumOfDepths() * texelArea(plan) / area, 1, 1e-3);
  }
}

TEST_P(StrandShadow, FiberCoversTheTwoTexelsNextToItInEachRow) {
  // Along the rows of one axis, a quarter of a texel above the middles of the other.
  const FlatMap flat(16, 1);
  for (const bool alongX : {true, false}) {
    SCOPED_TRACE(alongX);
    const auto at = [&](double along, double across) {
      return alongX ? flat.at(along, across) : flat.at(across, along);
    };
    Hair hair;
    hair.radius = static_cast<float>(0.1 * flat.texel);
    hair.positions = {at(3.5, 6.75), at(10.0, 6.75)};
    const StrandShadowPlan plan = planFor(flat.def, {hair.shadowed()});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const MapWords map = run.map();
    const auto tau = [&](size_t along, size_t across) {
      const size_t texel = alongX ? across * 16 + along : along * 16 + across;
      return map.depth(texel, 0) / static_cast<double>(plan.view.tauScale);
    };
    for (const size_t along : {4u, 5u, 8u, 9u}) {
      EXPECT_NEAR(tau(along, 6), 0.2 * 0.75, 1e-4) << along;
      EXPECT_NEAR(tau(along, 7), 0.2 * 0.25, 1e-4) << along;
    }
    // It begins in the middle of a row, and ends at the edge of one.
    EXPECT_NEAR(tau(3, 6), 0.2 * 0.75 / 2, 1e-4);
    EXPECT_EQ(tau(2, 6) + tau(10, 6) + tau(11, 6) + tau(5, 5) + tau(5, 8), 0);
  }
}

TEST_P(StrandShadow, StrandsFromOutsideMarkOnlyTheTexelsThatTheyPass) {
  const FlatMap flat(16, 1);
  // Two that are longer along y and along x than across, from and to far outside.
  const double slope = 0.75;
  for (const bool alongX : {true, false}) {
    SCOPED_TRACE(alongX);
    const auto at = [&](double along) {
      const double across = 9.9 - slope * along;
      return alongX ? flat.at(along, across) : flat.at(across, along);
    };
    Hair hair;
    hair.positions = {at(-40), at(8.3), at(5.2), at(60)};
    const StrandShadowPlan plan = planFor(flat.def, {hair.shadowed()});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const MapWords map = run.map();
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        // In each row the two next to where the strands cross its middle.
        const double middle = 9.9 - slope * ((alongX ? x : y) + 0.5) - 0.5;
        const bool expected = std::abs((alongX ? y : x) - middle) < 1;
        EXPECT_EQ(map.hasHair(static_cast<size_t>(y * 16 + x)), expected) << x << ", " << y;
      }
  }
}

/// Points on strands and the light that hair in front of them lets through to them.
class Receivers {
 public:
  /// \param beam width of the reference's beam [m].
  Receivers(const Hair& hair, const LightAxes& light, uint32_t count, double beam) {
    const std::vector<ShadowFiber> fibers = hair.fibers();
    Random random(11);
    for (uint32_t i = 0; i < count; ++i) {
      const auto at = static_cast<size_t>(random.between(0, static_cast<double>(fibers.size())));
      const double share = random.unit();
      points.push_back(toFloat4(fibers[at].from + (fibers[at].to - fibers[at].from) * share));
      expected.push_back(
          std::exp(-reference::beamDepth(fibers, light, toVector(points.back()), beam)));
    }
  }
  std::vector<Float4> points;
  std::vector<double> expected;
};

// Splatting and reading spread a fiber with the variance of a beam of two texels.
TEST_P(StrandShadow, TransmittanceIsThatOfABeamThroughTheHair) {
  static const Hair hair = headOfHair(4000, 12);
  const StrandShadowView view = planFor(headDef(256, 0), {}).view;
  static const Receivers receivers(hair, axesOf(view), 500,
                                   2 * static_cast<double>(view.texelSize));
  struct Level {
    uint32_t layers;
    double mean, max;
  };
  // Distances alone have the mean density where hair is denser or thinner: a point can be off by
  // any amount, and the mean alone says something. What they hold, the next test knows exactly.
  for (const Level level : {Level{0, 0.145, 1}, Level{4, 0.049, 0.30}, Level{8, 0.0305, 0.18},
                            Level{16, 0.0225, 0.125}}) {
    const StrandShadowPlan plan = planFor(headDef(256, level.layers), {hair.shadowed()});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const std::vector<float> seen = run.transmittance(receivers.points);
    double mean = 0, max = 0;
    for (size_t i = 0; i < seen.size(); ++i) {
      const double error = std::abs(static_cast<double>(seen[i]) - receivers.expected[i]);
      mean += error / static_cast<double>(seen.size());
      keepLargest(max, error);
    }
    EXPECT_LT(mean, level.mean) << level.layers << " layers";
    EXPECT_LT(max, level.max) << level.layers << " layers";
    RecordProperty("layers" + std::to_string(level.layers),
                   testing::PrintToString(std::pair(mean, max)));
  }
}

// The texels around each point, in double precision from the hair alone: nearest hair, optical
// depth of each layer, bilinear weights. What remains is rounding, of quanta and of positions on
// the map (2^-16 texels). Ten times what lavapipe and llvmpipe have.
TEST_P(StrandShadow, TransmittanceIsThatOfTheTexelsInDoublePrecision) {
  static const Hair hair = headOfHair(4000, 12);
  const StrandShadowView view = planFor(headDef(256, 0), {}).view;
  static const reference::ShadowMapReference map(
      {rowOf(view.mapX), rowOf(view.mapY), rowOf(view.mapZ), rowOf(view.mapW), view.width,
       view.height, static_cast<double>(view.texelSize), std::nullopt},
      hair.fibers());
  static const Receivers receivers(hair, axesOf(view), 500,
                                   2 * static_cast<double>(view.texelSize));
  for (const uint32_t layers : {0u, 1u, 4u, 8u, 16u}) {
    const StrandShadowPlan plan = planFor(headDef(256, layers), {hair.shadowed()});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const std::vector<float> seen = run.transmittance(receivers.points);
    const reference::ShadowReading reading = {layers, static_cast<double>(plan.view.layerRange),
                                              static_cast<double>(plan.view.bias),
                                              static_cast<double>(plan.view.extinction)};
    double mean = 0, max = 0;
    for (size_t i = 0; i < seen.size(); ++i) {
      const double expected = map.light(toVector(receivers.points[i]), reading);
      const double error = std::abs(static_cast<double>(seen[i]) - expected);
      mean += error / static_cast<double>(seen.size());
      keepLargest(max, error);
    }
    EXPECT_LT(mean, 2e-5) << layers << " layers";
    EXPECT_LT(max, 1.2e-4) << layers << " layers";
    RecordProperty("exact" + std::to_string(layers), testing::PrintToString(std::pair(mean, max)));
  }
}

// At the middle of a texel light is that of the texel alone.
TEST_P(StrandShadow, SoftLightIsTheMeanOfFiveTexels) {
  static const Hair hair = headOfHair(4000, 12);
  const StrandShadowPlan plan = planFor(headDef(256, 8), {hair.shadowed()});
  const StrandShadowView& view = plan.view;
  const Receivers receivers(hair, axesOf(view), 500, 2 * static_cast<double>(view.texelSize));
  const Eigen::Vector4d rows[] = {rowOf(view.mapX), rowOf(view.mapY)};
  const Eigen::Vector2d offsets[] = {{0, 0}, {1.8, 0.7}, {-0.7, 1.8}, {-1.8, -0.7}, {0.7, -1.8}};
  std::vector<Float4> points, middles;
  for (const Float4& point : receivers.points) {
    const Vector3d position = toVector(point);
    bool isNearEdge = false;
    std::vector<Float4> five;
    for (const Eigen::Vector2d& offset : offsets) {
      Vector3d middle = position;
      for (int axis = 0; axis < 2; ++axis) {
        const double at = rows[axis].dot(position.homogeneous());
        const double share = at + offset[axis] - std::floor(at + offset[axis]);
        isNearEdge = isNearEdge || std::abs(share - 0.5) > 0.499;
        middle += (std::floor(at + offset[axis]) + 0.5 - at) * static_cast<double>(view.texelSize) *
                  rows[axis].head<3>().normalized();
      }
      five.push_back(toFloat4(middle));
    }
    if (isNearEdge) continue;
    points.push_back(point);
    middles.insert(middles.end(), five.begin(), five.end());
  }
  ASSERT_GT(points.size(), 400u);
  MapRun run(gpu(), plan);
  run.draw(hair);
  const std::vector<float> soft = run.transmittance(points, true),
                           each = run.transmittance(middles);
  for (size_t i = 0; i < soft.size(); ++i) {
    float sum = 0;
    for (size_t k = 0; k < 5; ++k) sum += each[5 * i + k];
    EXPECT_NEAR(soft[i], sum / 5, 1e-3f) << "point " << i;
  }
  EXPECT_EQ(run.transmittance({{1e6f, 0, 0, 0}}, true), std::vector<float>{1});
}

// A strand alone that goes through the map at a slope of 1: the nearest of its hair in the texels
// around a point is up to two texels nearer to the light than the point.
TEST_P(StrandShadow, BiasKeepsAStrandFromShadowingItself) {
  FlatMap flat(64, 8);
  const double texel = flat.texel;
  const LightAxes& axes = flat.axes;
  Hair hair;
  hair.radius = static_cast<float>(0.09 * texel);
  const Vector3d from = (axes.x * -9.3 + axes.y * 4.1 + axes.toLight * 9.3) * texel;
  const Vector3d to = (axes.x * 11.2 + axes.y * 1.7 - axes.toLight * 11.2) * texel;
  hair.positions = {toFloat4(from), toFloat4(to)};
  std::vector<Float4> points;
  for (int i = 1; i < 400; ++i) points.push_back(toFloat4(from + (to - from) * (i / 400.0)));
  // The first layer ends a texel behind the nearest hair: all that a strand adds is soon there.
  flat.def.layerRange = static_cast<float>(64 * texel);
  const auto lost = [&](float bias) {
    flat.def.biasTexels = bias;
    MapRun run(gpu(), planFor(flat.def, {hair.shadowed()}));
    run.draw(hair);
    double worst = 0;
    for (const float light : run.transmittance(points))
      keepLargest(worst, 1 - static_cast<double>(light));
    return worst;
  };
  const double none = lost(0), half = lost(0.5f), two = lost(2);
  EXPECT_GT(none, 0.06);
  EXPECT_LT(half, none);
  EXPECT_EQ(two, 0);
  RecordProperty("lost", testing::PrintToString(std::pair(none, half)));
}

// K40
TEST_P(StrandShadow, ScaleOfTheSceneDoesNotMatter) {
  for (const uint32_t layers : {0u, 8u}) {
    const auto seen = [&](double scale) {
      const Hair hair = headOfHair(2500, 12, scale);
      MapRun run(gpu(), planFor(headDef(128, layers, scale), {hair.shadowed()}));
      run.draw(hair);
      std::vector<Float4> points;
      for (size_t i = 7; i < hair.positions.size(); i += 71) points.push_back(hair.positions[i]);
      return run.transmittance(points);
    };
    const std::vector<float> metres = seen(1);
    EXPECT_LT(*std::min_element(metres.begin(), metres.end()), 0.3f);
    for (const double scale : {1e-3, 1e3}) {
      const std::vector<float> others = seen(scale);
      for (size_t i = 0; i < metres.size(); ++i)
        EXPECT_NEAR(others[i], metres[i], 1e-3f) << layers << " layers, " << scale << ", " << i;
    }
  }
}

TEST_P(StrandShadow, OrderOfTheStrandsDoesNotChangeABit) {
  Hair hair = headOfHair(1200, 12);
  const StrandShadowPlan plan = planFor(headDef(128, 8), {hair.shadowed()});
  MapRun run(gpu(), plan);
  run.draw(hair);
  const std::vector<uint32_t> words = run.words();
  Hair other = hair;
  const uint32_t strands = hair.strands(), vertices = hair.vertices;
  // 7 has no factor in common with 1200.
  for (uint32_t s = 0; s < strands; ++s)
    std::copy_n(hair.positions.begin() + s * vertices, vertices,
                other.positions.begin() + (s * 7 + 5) % strands * vertices);
  run.draw(other);
  EXPECT_EQ(run.words(), words);
}

TEST(StrandShadowApis, AllHaveTheSameBits) {
  const Hair hair = headOfHair(1200, 12);
  const StrandShadowPlan plan = planFor(headDef(128, 8), {hair.shadowed()});
  std::vector<uint32_t> first;
  for (const Api api : kApis) {
    Gpu& gpu = Gpu::of(api);
    if (gpu.device() == nullptr) continue;
    MapRun run(gpu, plan);
    run.draw(hair);
    if (first.empty()) first = run.words();
    EXPECT_EQ(run.words(), first) << apiName(api);
  }
}

TEST_P(StrandShadow, SumsDoNotOverflowWhenAllHairIsInOneTexel) {
  // Strands that go back and forth over a texel from corner to corner, all in the same place, of a
  // width that leaves no more room in the sums than rounding takes.
  FlatMap flat(64, 4);
  Hair hair;
  hair.vertices = 64;
  for (uint32_t i = 0; i < 1000 * hair.vertices; ++i)
    hair.positions.push_back(i % 2 == 0 ? flat.at(32.002, 32.002) : flat.at(32.998, 32.998));
  hair.radius = static_cast<float>(0.999 * 0.75 * 0x1p18 / (2 * std::numbers::sqrt2 * 63000) *
                                   flat.texel / 1.001);
  const StrandShadowPlan plan = planFor(flat.def, {hair.shadowed()});
  EXPECT_EQ(plan.view.tauScale, 0x1p14f);
  MapRun run(gpu(), plan);
  run.draw(hair);
  const double area = reference::coveredArea(hair.fibers(), flat.axes);
  EXPECT_GT(area / texelArea(plan), 10000);
  EXPECT_NEAR(run.sumOfDepths() * texelArea(plan) / area, 1, 1e-3);
  const Vector3d middle = toVector(flat.at(32.5, 32.5));
  const float behind = run.transmittance({toFloat4(middle - flat.axes.toLight * 0.1)})[0];
  EXPECT_LT(behind, 1e-6f);
  // A little wider, and the sums need larger quanta.
  hair.radius *= 1.004f;
  EXPECT_EQ(planFor(flat.def, {hair.shadowed()}).view.tauScale, 0x1p13f);
}

TEST_P(StrandShadow, NothingOfTheHairBeforeIsLeft) {
  const Hair before = headOfHair(600, 12), now = headOfHair(500, 7);
  const StrandShadowPlan plan = planFor(headDef(128, 8), {before.shadowed()});
  MapRun run(gpu(), plan), other(gpu(), plan);
  run.draw(before);
  run.draw(now);
  other.draw(now);
  const MapWords map = run.map(), expected = other.map();
  for (size_t i = 0; i < map.count(); ++i) {
    ASSERT_EQ(map.nearest(i), expected.nearest(i)) << i;
    for (uint32_t layer = 0; layer < 8; ++layer)
      ASSERT_EQ(map.depth(i, layer), expected.depth(i, layer)) << i;
  }
}

TEST_P(StrandShadow, HairInTheLightDoesNotShadeItself) {
  // Wider strands than there are, alone, at slopes up to 45 degrees from the light's plane.
  for (const uint32_t layers : {0u, 8u}) {
    StrandShadowDef def = headDef(256, layers);
    const LightAxes axes = axesOf(planFor(def, {}).view);
    Hair hair;
    hair.vertices = 3;
    std::vector<Float4> points;
    for (int i = -8; i <= 8; ++i) {
      const Vector3d root = axes.x * (0.02 * i) - axes.y * 0.1;
      const Vector3d displacement =
          axes.y * 0.2 + axes.toLight * (0.2 / 8 * i) + axes.x * (0.003 * i);
      for (int v = 0; v < 3; ++v)
        hair.positions.push_back(toFloat4(root + displacement * (0.5 * v)));
      for (int p = 0; p <= 40; ++p) points.push_back(toFloat4(root + displacement * (0.025 * p)));
    }
    hair.radius = 200e-6f;
    MapRun run(gpu(), planFor(def, {hair.shadowed()}));
    run.draw(hair);
    const std::vector<float> seen = run.transmittance(points);
    EXPECT_GT(*std::min_element(seen.begin(), seen.end()), 0.98f) << layers << " layers";
  }
}

TEST_P(StrandShadow, WhatIsNotFiniteOrOutsideAddsNothing) {
  const Hair good = headOfHair(300, 5);
  Hair bad = good;
  const auto add = [&](Float4 p, Float4 q) {
    for (uint32_t v = 0; v < bad.vertices; ++v) bad.positions.push_back(v % 2 == 0 ? p : q);
  };
  add({kNan, 0, 0, 0}, {0, 0, 0, 0});
  add({0, kNan, kNan, kNan}, {0, kInf, 0, 0});
  add({0, -kInf, 0, 0}, {0, kInf, 0, 0});
  add({5, 5, 5, 0}, {5, 5, 9, 0});
  add({1e30f, 0, 0, 0}, {0, 0, 0, 0});
  add({-3e38f, 3e38f, 0, 0}, {3e38f, 3e38f, 3e38f, 0});
  // One plan for both; the lengths of strands that are not finite are no help to it.
  ShadowedHair known = good.shadowed();
  known.strandCount = bad.strands();
  const StrandShadowPlan plan = planFor(headDef(64, 4), {known});
  MapRun run(gpu(), plan), other(gpu(), plan);
  run.draw(good);
  other.draw(bad);
  EXPECT_EQ(other.words(), run.words());
  const std::vector<float> seen = other.transmittance(
      {{kNan, 0, 0, 0}, {0, kInf, 0, 0}, {0, 0, -kInf, 0}, {3e38f, 3e38f, 3e38f, 0}, {0, 9, 0, 0}});
  for (const float t : seen) EXPECT_EQ(t, 1);
}

TEST_P(StrandShadow, OddStrandsAndMapsLeaveNoNaN) {
  Hair hair = headOfHair(200, 3);
  const auto add = [&](Float4 p, Float4 q) {
    for (uint32_t v = 0; v < hair.vertices; ++v) hair.positions.push_back(v % 2 == 0 ? p : q);
  };
  add({0, 0, 0, 0}, {0, 0, 0, 0});                     // without a length
  add({-1e6f, 0.01f, 0, 0}, {1e6f, 0.02f, 0.01f, 0});  // through all of the map
  add({0, 0, 0, 0}, {3.5e5f, 7.5e5f, 5.5e5f, 0});      // along the light
  add({-1e17f, -1e17f, 1e17f, 0}, {1e17f, 1e17f, -1e17f, 0});
  std::vector<Float4> points = hair.positions;
  for (int i = -40; i <= 40; ++i) points.push_back({0.01f * static_cast<float>(i), 0, 0, 0});
  for (const uint32_t layers : {0u, 3u, 16u}) {
    for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(1u, 7u), std::pair(33u, 2u)}) {
      hair.thickness.clear();
      StrandShadowPlan plan = planFor(headDef(64, layers), {hair.shadowed()});
      plan.view.width = width;
      plan.view.height = height;
      plan.words = width * height * (1 + layers);
      plan.view.mapX.w = 0.5f * static_cast<float>(width);
      plan.view.mapY.w = 0.5f * static_cast<float>(height);
      hair.thickness.assign(hair.strands(), 1.0f);
      hair.thickness[1] = std::numeric_limits<float>::quiet_NaN();
      hair.thickness[2] = std::numeric_limits<float>::infinity();
      hair.thickness[3] = -1;
      for (const float radius : {0.0f, 1e-4f, 10.0f}) {
        hair.radius = radius;
        MapRun run(gpu(), plan);
        run.draw(hair);
        const MapWords map = run.map();
        for (size_t i = 0; i < map.count(); ++i) {
          EXPECT_TRUE(!map.hasHair(i) || map.nearest(i) < 0x7f800000u);
          for (uint32_t layer = 1; layer < layers; ++layer)
            EXPECT_LE(map.depth(i, layer - 1), map.depth(i, layer));
        }
        for (const float t : run.transmittance(points)) EXPECT_TRUE(t >= 0 && t <= 1) << t;
      }
    }
  }
}

TEST_P(StrandShadow, FollowHairsThatArePlacedShadeLikeStoredOnes) {
  const HairAsset asset = wavyAsset(60, 9);
  std::vector<reference::Pose> poses;
  std::vector<RootTransform> roots;
  Random random(2);
  for (uint32_t s = 0; s < asset.strandCount; ++s)
    poses.push_back({random.rotation(), random.vector(0.1)});
  for (int frame = 0; frame < 2; ++frame)
    for (const reference::Pose& pose : poses) roots.push_back(toRoot(pose));
  std::vector<FollowHairRecord> follows(500);
  for (uint32_t f = 0; f < follows.size(); ++f) {
    follows[f].guides = {f % 60, (f * 7 + 1) % 60, 60, 0};  // the third one is none
    follows[f].weights = {f % 3 == 0 ? 0.7f : 1.0f, f % 3 == 0 ? 0.3f : 0.0f, 0.5f, 0};
    follows[f].offset = toFloat4(random.vector(0.02), random.between(0, 2));
  }
  follows[17].guides = {90, 91, 92, 0};  // without a guide
  StrandRun strands(gpu(), asset, follows);
  strands.reset(poses);
  strands.constants.tipSeparation = 1.5f;
  strands.updateFollowHairs();
  strands.run();

  Hair stored;
  stored.vertices = 9;
  stored.positions = strands.positions();
  for (uint32_t v = 0; v < 9; ++v)  // nothing wrote those
    stored.positions[(60 + 17) * 9 + v].x = std::numeric_limits<float>::quiet_NaN();
  ShadowedHair evaluated;
  evaluated.vertexCount = 9;
  evaluated.strandCount = 560;
  evaluated.guideCount = 60;
  evaluated.tipSeparation = 1.5f;
  evaluated.fiberRadius = stored.radius;
  StrandShadowDef def = headDef(64, 4);
  def.center = {0, 0, 0};
  def.radius = 0.6f;
  const StrandShadowPlan plan = planFor(def, {evaluated});
  MapRun run(gpu(), plan);
  run.draw(stored);
  const std::vector<uint32_t> words = run.words();
  EXPECT_GT(run.sumOfDepths(), 1);

  const GuardedBuffer<Float4> guides(gpu(), "guides",
                                     {stored.positions.begin(), stored.positions.begin() + 60 * 9});
  const GuardedBuffer<FollowHairRecord> followBuffer(gpu(), "follows", follows);
  const GuardedBuffer<RootTransform> rootBuffer(gpu(), "roots", roots);
  evaluated.positions = guides.id();
  evaluated.followHairRecords = followBuffer.id();
  evaluated.rootTransforms = gpu().resources.whole(rootBuffer.id());
  MapRun other(gpu(), plan);
  other.draw({evaluated});
  EXPECT_EQ(other.words(), words);
}

TEST_P(StrandShadow, StrandsThatFadeCoverLess) {
  const Hair hair = headOfHair(400, 6);
  const StrandShadowPlan plan = planFor(headDef(64, 2), {hair.shadowed()});
  const GuardedBuffer<Float4> positions(gpu(), "shadowPositions", hair.positions);
  ShadowedHair shadowed = hair.shadowed();
  shadowed.positions = positions.id();
  shadowed.fadingCount = 100;
  shadowed.fade = 0.25f;
  MapRun run(gpu(), plan);
  run.draw({shadowed});
  const std::vector<ShadowFiber> fibers = hair.fibers();
  const std::span all(fibers);
  const LightAxes axes = axesOf(plan.view);
  const double expected = reference::coveredArea(all.first(300 * 5), axes) +
                          0.25 * reference::coveredArea(all.subspan(300 * 5), axes);
  EXPECT_NEAR(run.sumOfDepths() * texelArea(plan) / expected, 1, 1e-3);
}

TEST_P(StrandShadow, LightFromAPointHasTexelsThatGrowWithTheDistance) {
  // At (0, 0, 2), looking down -z: a texel is 1 mm at a distance of 1 m.
  Hair hair;
  hair.radius = 100e-6f;
  StrandShadowPlan plan = planFor(headDef(64, 4), {});
  plan.view.mapX = {1000, 0, -32, 64};
  plan.view.mapY = {0, 1000, -32, 64};
  plan.view.mapZ = {0, 0, -1, 2};
  plan.view.mapW = {0, 0, -1, 2};
  plan.view.texelSize = 1e-3f;
  plan.view.nearW = 0.1f;
  plan.view.layerRange = 1;
  plan.view.maxRadius = 1;
  plan.view.bias = 1e-3f;
  for (const float distance : {0.7f, 1.5f, 2.5f}) {
    const float z = 2 - distance;
    hair.positions = {{-0.008f, 0.0013f, z, 0}, {0.011f, -0.002f, z, 0}};
    // Behind the light.
    hair.positions.push_back({0, 0.001f, 3, 0});
    hair.positions.push_back({0.001f, 0, 3.0f, 0});
    MapRun run(gpu(), plan);
    run.draw(hair);
    const double texel = 1e-3 * static_cast<double>(distance);
    const double area = 2 * 100e-6 * std::hypot(0.019, 0.0033);
    EXPECT_NEAR(run.sumOfDepths() * texel * texel / area, 1, 1e-3);
    // In its shadow, on the ray through the middle of the strand; and in front of it.
    const float share = 1.2f;
    const std::vector<float> seen =
        run.transmittance({{0.0015f * share, -0.00035f * share, 2 - distance * share, 0},
                           {0.0015f * 0.9f, -0.00035f * 0.9f, 2 - distance * 0.9f, 0},
                           {0, 0, 3, 0}});
    EXPECT_NEAR(-std::log(static_cast<double>(seen[0])) * static_cast<double>(distance), 0.15,
                0.06);
    EXPECT_EQ(seen[1], 1);
    EXPECT_EQ(seen[2], 1);
  }
}

TEST(StrandShadowPlan, TexelsStayInPlaceWhenTheBallMoves) {
  StrandShadowDef def = headDef(512, 4);
  const StrandShadowPlan still = planFor(def, {});
  for (int i = 0; i < 50; ++i) {
    def.center.x += 0.00137f;
    def.center.z -= 0.00071f;
    const StrandShadowPlan moved = planFor(def, {});
    for (const auto row : {&StrandShadowView::mapX, &StrandShadowView::mapY}) {
      const Float4 &a = still.view.*row, &b = moved.view.*row;
      EXPECT_EQ((Float4{a.x, a.y, a.z, 0}), (Float4{b.x, b.y, b.z, 0}));
      EXPECT_EQ(std::floor(b.w - a.w), b.w - a.w);
      // All of the ball is in the map, with the texels around.
      const double middle =
          toVector(b).dot(toVector(Float4{def.center.x, def.center.y, def.center.z, 0})) +
          static_cast<double>(b.w);
      const double range = static_cast<double>(def.radius / moved.view.texelSize);
      EXPECT_GE(middle - range, 0.5);
      EXPECT_LE(middle + range, 511.5);
    }
  }
}

TEST(StrandShadowPlan, RefusesWhatNoMapCanHold) {
  const auto message = [](const StrandShadowDef& def) {
    const Result<StrandShadowPlan> plan = detail::planStrandShadow(def, {});
    return plan ? std::string() : plan.error().message;
  };
  EXPECT_EQ(message(headDef(4, 0)), "");
  expectHas(message(headDef(3, 0)), "4 to 8192");
  expectHas(message(headDef(8193, 0)), "4 to 8192");
  expectHas(message(headDef(64, 17)), "16");
  StrandShadowDef def = headDef(64, 4);
  def.radius = 0;
  expectHas(message(def), "radius");
  def = headDef(64, 4);
  def.center.y = std::numeric_limits<float>::quiet_NaN();
  expectHas(message(def), "ball");
  def = headDef(64, 4);
  ShadowedHair hair = headOfHair(10, 3).shadowed();
  hair.maxThickness = std::numeric_limits<float>::quiet_NaN();
  expectHas(detail::planStrandShadow(def, std::span(&hair, 1)).error().message, "thickness nan");
  def.firstWord = 0xffffffffu;
  expectHas(message(def), "2^32");
}

TEST(StrandShadowPlan, VolumeIsThatOfEvenHairAndDoesNotGrowWithStrayStrands) {
  // Strands along the edge of 0.5 m of a box of 0.5 x 0.25 x 0.125 m.
  for (const double scale : {1e-3, 1.0, 1e3}) {
    std::vector<Float4> positions;
    for (int i = 0; i < 64; ++i)
      for (int j = 0; j < 32; ++j)
        for (int v = 0; v < 5; ++v)
          positions.push_back(toFloat4(Vector3d(0.125 * v, 0.25 / 63 * i, 0.125 / 31 * j) * scale));
    const double box = 0.5 * 0.25 * 0.125 * std::pow(scale, 3);
    EXPECT_NEAR(detail::hairVolume(positions, 5) / box, 1, 0.1);
    positions[17].x = std::numeric_limits<float>::quiet_NaN();
    for (int v = 0; v < 5; ++v)
      positions.push_back(toFloat4(Vector3d(0.1 * v, 0, 0.1 * v) * scale));
    EXPECT_NEAR(detail::hairVolume(positions, 5) / box, 1, 0.25);
  }
  EXPECT_EQ(detail::hairVolume({}, 5), 0);
  EXPECT_EQ(detail::hairVolume(std::vector<Float4>(10, Float4{1, 1, 1, 0}), 5), 0);
}

TEST(StrandShadowPlan, SpacingIsTheFreePathOfARay) {
  // 1000 strands of 0.1 m and 0.2 mm in a ball of 1 m: what a fiber shows on average is pi / 4 of
  // width times length.
  ShadowedHair hair;
  hair.vertexCount = 8;
  hair.strandCount = hair.guideCount = 1000;
  hair.strandLength = 0.1f;
  hair.fiberRadius = 1e-4f;
  hair.opacity = 0.5f;
  StrandShadowDef def = headDef(64, 0);
  def.radius = 1;
  const StrandShadowPlan plan = planFor(def, {hair});
  const double area = std::numbers::pi / 4 * 1000 * 0.1 * 2e-4;
  EXPECT_NEAR(static_cast<double>(plan.spacing) * area / (4 * std::numbers::pi / 3), 1, 1e-5);
  EXPECT_NEAR(static_cast<double>(plan.view.extinction * plan.spacing), 0.5, 1e-5);
  hair.volume = 0.25f;
  EXPECT_NEAR(static_cast<double>(planFor(def, {hair, hair}).spacing) * area, 0.25, 1e-5);
  def.volume = 0.125f;
  EXPECT_NEAR(static_cast<double>(planFor(def, {hair}).spacing) * area, 0.125, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(All, StrandShadow, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
