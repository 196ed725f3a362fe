// Lights and shadows of a view in every method of transparency: opaque geometry in front of hair,
// spot lights, and point lights with shadows.
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "oit/shared_tangle.h"
#include "support/extremes.h"

namespace pelage::test {
namespace {

constexpr uint32_t kLitPixels = 48, kTexels = 128;
constexpr std::pair<Transparency, const char*> kLitMethods[] = {
    {Transparency::kAlphaTest, "alphaTest"}, {Transparency::kStochastic, "stochastic"},
    {Transparency::kWindowed, "windowed"},   {Transparency::kHybrid8, "hybrid8"},
    {Transparency::kShortCut, "shortCut"},   {Transparency::kTiles, "tiles"}};
using LitCase = std::tuple<Api, std::pair<Transparency, const char*>>;

class LightsOfAView : public SharedTangleTest<LitCase> {
 protected:
  void fill(TangleRun& run) override { run.add({.strands = 500, .opacity = 0.5f}); }

  RenderedImage draw(const Light& light) { return draw(std::span(&light, 1)); }
  RenderedImage draw(std::span<const Light> lights) {
    tangleRun().run.step(0);
    tangleRun().lists.clear();
    TransparencySettings settings = {.method = std::get<1>(GetParam()).first};
    const View view = tangleView(kLitPixels);
    expectOk(tangleRun().run.scene.draw(view, lights, settings, tangleRun().lists));
    return tangleRun().renderLists(view).value_or(RenderedImage{});
  }

  /// A map whose left part, up to this column, is in front of all hair; or all but that part.
  OpaqueShadow opaque(uint32_t darkColumns, bool others = false) {
    ResourceTable& resources = tangleRun().resources();
    std::vector<float> depths(size_t{kTexels} * kTexels, 1);
    for (size_t i = 0; i < depths.size(); ++i)
      if ((i % kTexels < darkColumns) != others) depths[i] = 0;
    OpaqueShadow map;
    map.depth = resources.add("opaque shadow", depths);
    map.width = map.height = kTexels;
    // From the front: 0.64 m of x and y, depth 0 at z = 0.5.
    map.worldToClip.rows[0] = {3.125f, 0, 0, 0};
    map.worldToClip.rows[1] = {0, 3.125f, 0, 0};
    map.worldToClip.rows[2] = {0, 0, -1, 0.5f};
    map.worldToClip.rows[3] = {0, 0, 0, 1};
    return map;
  }
  void forget(const OpaqueShadow& map) { tangleRun().resources().remove(map.depth); }

  static Light fromTheFront(HairShadow shadow) {
    Light light = {.direction = {0, 0, 1}, .shadow = shadow, .shadowSize = kTexels};
    return light;
  }
};

/// Pixels of columns first..last-1 that differ; those without hair do not count.
size_t differing(const RenderedImage& a, const RenderedImage& b, uint32_t first, uint32_t last) {
  size_t count = 0, covered = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    if (i % kLitPixels < first || i % kLitPixels >= last) continue;
    covered += a.pixels[i].w > 0 ? 1 : 0;
    count += a.pixels[i] == b.pixels[i] ? 0 : 1;
  }
  EXPECT_GT(covered, 100u);
  return count;
}

/// Compares columns first..last-1.
double largestDifference(const RenderedImage& a, const RenderedImage& b, uint32_t first,
                         uint32_t last) {
  double largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    if (i % kLitPixels >= first && i % kLitPixels < last)
      keepLargest(largest, maxDifference(a.pixels[i], b.pixels[i]));
  return largest;
}

/// Mean absolute difference of the colors of covered pixels; NaN where one is.
double meanDifference(const RenderedImage& a, const RenderedImage& b) {
  double sum = 0, covered = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const Float4 &p = a.pixels[i], &q = b.pixels[i];
    if (!(p.w > 0)) continue;
    covered += 1;
    sum += std::abs(static_cast<double>(p.x - q.x)) + std::abs(static_cast<double>(p.y - q.y)) +
           std::abs(static_cast<double>(p.z - q.z));
  }
  return sum / (3 * covered);
}

TEST_P(LightsOfAView, OpaqueGeometryInFrontTakesTheLightOfItsSilhouetteAlone) {
  for (const HairShadow shadow : {HairShadow::kNone, HairShadow::kDeep}) {
    Light light = fromTheFront(shadow);
    const RenderedImage lit = draw(light);
    light.opaque = opaque(kTexels / 2);
    const RenderedImage half = draw(light);
    forget(light.opaque);
    light.opaque = opaque(0);
    EXPECT_EQ(differing(draw(light), lit, 0, kLitPixels), 0u) << "nothing in the map";
    forget(light.opaque);
    light.opaque = {};
    light.color = {0, 0, 0};
    const RenderedImage dark = draw(light);
    EXPECT_GT(differing(dark, lit, 0, kLitPixels), 100u);
    // A texel is 5 mm, a pixel 5.5 mm: the edge is in one column on both sides of the middle.
    const uint32_t middle = kLitPixels / 2;
    EXPECT_EQ(differing(half, dark, 0, middle - 1), 0u) << "in the silhouette";
    EXPECT_EQ(differing(half, lit, middle + 1, kLitPixels), 0u) << "outside of it";
  }
}

// One of them lights the right half, and one the left half: each has a map of its own.
TEST_P(LightsOfAView, EachHasItsOwnOpaqueGeometry) {
  Light right = fromTheFront(HairShadow::kDeep);
  right.color = {0.8f, 0.1f, 0.3f};
  Light left = fromTheFront(HairShadow::kNone);
  left.color = {0.1f, 0.7f, 0.2f};
  // The same ambient light in all pictures.
  Light none = left;
  none.color = none.ambient = {0, 0, 0};
  // A shadow map dims ambient light: all pictures have one of the same hair.
  Light mapped = none;
  mapped.shadow = HairShadow::kDeep;
  const RenderedImage leftAlone = draw(std::vector<Light>{left, mapped});
  left.ambient = {0, 0, 0};
  const RenderedImage rightAlone = draw(std::vector<Light>{right, none});
  right.opaque = opaque(kTexels / 2);
  left.opaque = opaque(kTexels / 2, true);
  const RenderedImage both = draw(std::vector<Light>{right, left});
  forget(right.opaque);
  forget(left.opaque);
  const uint32_t middle = kLitPixels / 2;
  EXPECT_LT(largestDifference(both, leftAlone, 0, middle - 1), 2e-3);
  EXPECT_LT(largestDifference(both, rightAlone, middle + 1, kLitPixels), 2e-3);
  EXPECT_GT(largestDifference(leftAlone, rightAlone, 0, middle - 1), 0.05);
}

TEST_P(LightsOfAView, SpotLightThatLooksElsewhereIsDark) {
  Light light = fromTheFront(HairShadow::kDeep);
  light.hasPosition = true;
  light.position = {0, 0, 1};
  const RenderedImage point = draw(light);
  // All of the hair is in the inner cone.
  light.outerConeAngle = 0.7f;
  light.innerConeAngle = 0.6f;
  EXPECT_LT(meanDifference(draw(light), point), 0.01);
  light.direction = {0, 1, 0};
  const RenderedImage away = draw(light);
  light.color = {0, 0, 0};
  const RenderedImage dark = draw(light);
  EXPECT_EQ(differing(away, dark, 0, kLitPixels), 0u);
  EXPECT_GT(meanDifference(point, dark), 0.02);
}

// Its map looks along the cone: narrower than the ball of all hair.
TEST_P(LightsOfAView, SpotLightLightsItsDiscAsAPointLightDoes) {
  Light light = fromTheFront(HairShadow::kDeep);
  light.hasPosition = true;
  light.position = {0, 0, 1};
  const RenderedImage point = draw(light);
  light.outerConeAngle = 0.09f;
  light.innerConeAngle = 0.085f;
  const RenderedImage spot = draw(light);
  light.color = {0, 0, 0};
  const RenderedImage dark = draw(light);
  // Hair from 0.9 to 1.1 m in front of the light: the disc has a radius of 0.077 to 0.099 m, seen
  // from 0.4 to 0.6 m.
  double inside = 0, ofLight = 0;
  size_t lit = 0, outside = 0;
  for (size_t i = 0; i < spot.pixels.size(); ++i) {
    if (!(point.pixels[i].w > 0)) continue;
    const auto at = [](size_t pixel) {
      return (static_cast<double>(pixel) + 0.5) / kLitPixels - 0.5;
    };
    const double slope = 2 * std::tan(0.25) * std::hypot(at(i % kLitPixels), at(i / kLitPixels));
    const auto red = [i](const RenderedImage& image) {
      return static_cast<double>(image.pixels[i].x);
    };
    if (slope < 0.11) {
      inside += std::abs(red(spot) - red(point));
      ofLight += red(point) - red(dark);
      ++lit;
    } else if (slope > 0.26) {
      EXPECT_EQ(spot.pixels[i], dark.pixels[i]) << i;
      ++outside;
    }
  }
  EXPECT_GT(lit, 100u);
  EXPECT_GT(outside, 20u);
  // Its texels are a third of those of the map around the ball, and resolve single strands.
  EXPECT_LT(inside, 0.2 * ofLight);
}

TEST_P(LightsOfAView, PointLightFarAwayIsADirectionalLight) {
  constexpr float kDistance = 20;
  for (const HairShadow shadow : {HairShadow::kDepth, HairShadow::kDeep}) {
    Light light = fromTheFront(shadow);
    light.direction = {0.36f, 0.48f, 0.8f};
    const RenderedImage directional = draw(light);
    light.shadow = HairShadow::kNone;
    const RenderedImage plain = draw(light);
    light.shadow = shadow;
    light.hasPosition = true;
    light.position = {0.36f * kDistance, 0.48f * kDistance, 0.8f * kDistance};
    const float scale = kDistance * kDistance;
    light.color = {scale, scale, scale};
    const RenderedImage far = draw(light);
    // The texels of the two maps lie elsewhere: what a texel averages is a tenth of the shadow.
    const double shadowed = meanDifference(directional, plain);
    EXPECT_GT(shadowed, 0.015);
    EXPECT_LT(meanDifference(far, directional), 0.15 * shadowed);
    // In the hair, where it is a cube: all pixels are numbers.
    light.position = {0.01f, 0.02f, 0.03f};
    light.color = {0.01f, 0.01f, 0.01f};
    const RenderedImage inside = draw(light);
    light.shadow = HairShadow::kNone;
    EXPECT_GT(meanDifference(inside, draw(light)), 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LightsOfAView,
                         testing::Combine(testing::ValuesIn(kRuntimeApis),
                                          testing::ValuesIn(kLitMethods)),
                         [](const auto& one) {
                           return std::string(apiName(std::get<0>(one.param))) + "_" +
                                  std::get<1>(one.param).second;
                         });

}  // namespace
}  // namespace pelage::test
