// Depth maps of opaque geometry: how they are copied, and what hair sees of them.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <vector>

#include "pelage/view.h"
#include "shadow/opaque_shadow.h"
#include "shadow_test/gpu_structs.h"
#include "shadow_test/kernels.h"
#include "support/not_numbers.h"
#include "support/strand_run.h"

namespace pelage::test {
namespace {

using shadow_test::OpaqueShadowView;

constexpr uint32_t kSize = 64;
constexpr float kTexel = 0.01f;  // m

/// A light above, parallel, with depth 0 at y = 1 and 1 at y = -1. The map is 0.64 m wide; texel
/// (0, 0) is at x = -0.32, z = -0.32.
OpaqueShadowView viewFromAbove(bool reversed) {
  OpaqueShadowView view = {};
  const float scale = 2 / (kTexel * static_cast<float>(kSize));
  view.clipX = {scale, 0, 0, 0};
  view.clipY = {0, 0, -scale, 0};
  view.clipZ = reversed ? Float4{0, 0.5f, 0, 0.5f} : Float4{0, -0.5f, 0, 0.5f};
  view.clipW = {0, 0, 0, 1};
  view.width = view.height = kSize;
  view.reversedDepth = reversed ? 1 : 0;
  return view;
}

class OpaqueShadowMap : public GpuTest {
 protected:
  std::vector<float> light(const std::vector<float>& depths, OpaqueShadowView view,
                           const std::vector<Float4>& points, Float4 toLight = {0, 1, 0, 0}) {
    std::vector<uint32_t> words(kAround, kPattern);
    for (const float depth : depths) words.push_back(std::bit_cast<uint32_t>(depth));
    view.firstWord = kAround;
    const GuardedBuffer<Float4> pointBuffer(gpu(), "points", points);
    const GuardedBuffer<uint32_t> wordBuffer(gpu(), "words", words);
    const GuardedBuffer<OpaqueShadowView> views(gpu(), "views", {view});
    const GuardedBuffer<float> results(gpu(), "results", std::vector<float>(points.size(), -1));
    shadow_test::ReadOpaqueConstants constants = {};
    constants.opaqueToLight = toLight;
    constants.opaquePointCount = static_cast<uint32_t>(points.size());
    dispatch(gpu(), shadow_test::readOpaqueShadowVariant({}), points.size(),
             [&](PassBuilder& pass) {
               pointBuffer.bindTo(pass, "g_opaquePoints");
               wordBuffer.bindTo(pass, "g_opaqueMapWords");
               views.bindTo(pass, "g_opaqueViews");
               results.bindTo(pass, "g_opaqueResults");
               pass.constants("ReadOpaqueConstants", constants);
             });
    return results.read();
  }
  static constexpr uint32_t kAround = 32, kPattern = 0x5a17c0deu;
};

/// Depths of a box whose top is at y = 0.5, over texels 16..39 x 20..29.
std::vector<float> boxDepths(bool reversed) {
  const float empty = reversed ? 0.0f : 1.0f, top = reversed ? 0.75f : 0.25f;
  std::vector<float> depths(size_t{kSize} * kSize, empty);
  for (uint32_t y = 20; y < 30; ++y)
    for (uint32_t x = 16; x < 40; ++x) depths[size_t{y} * kSize + x] = top;
  return depths;
}

TEST_P(OpaqueShadowMap, BoxDarkensExactlyItsSilhouette) {
  const float low = -0.32f;
  const auto edge = [&](float texel) { return low + kTexel * texel; };
  for (const bool reversed : {false, true}) {
    std::vector<Float4> points;
    for (const float y : {-0.9f, 0.2f, 0.49f, 0.6f})
      for (int i = -70; i <= 70; ++i)
        for (int j = -70; j <= 70; j += 2)
          points.push_back({0.005f * static_cast<float>(i) + 0.0013f, y,
                            0.005f * static_cast<float>(j) + 0.0007f, 0});
    const std::vector<float> seen = light(boxDepths(reversed), viewFromAbove(reversed), points);
    size_t dark = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const Float4& p = points[i];
      // How far inside of the silhouette [texels]; the comparison of four texels blurs half of one.
      const float inside = std::min(std::min(p.x - edge(16), edge(40) - p.x),
                                    std::min(p.z - edge(20), edge(30) - p.z)) /
                           kTexel;
      if (p.y > 0.5f || inside < -0.501f) {
        EXPECT_EQ(seen[i], 1) << p.x << ", " << p.y << ", " << p.z;
      } else if (inside > 0.501f) {
        EXPECT_EQ(seen[i], 0) << p.x << ", " << p.y << ", " << p.z;
        ++dark;
      } else {
        EXPECT_TRUE(seen[i] >= 0 && seen[i] <= 1) << seen[i];
      }
    }
    EXPECT_GT(dark, 1000u);
    // In the middle between a dark texel's middle and a lit one's.
    EXPECT_NEAR(
        light(boxDepths(reversed), viewFromAbove(reversed), {{edge(16), 0, edge(25), 0}})[0], 0.5f,
        1e-3f);
  }
}

// A plane of slope 1 in a map is a stair; points on the plane are in front of half a step and
// behind the other half.
TEST_P(OpaqueShadowMap, BiasLightsHairOnTheSurfaceThatCastsTheShadow) {
  std::vector<float> depths;
  for (uint32_t y = 0; y < kSize; ++y)
    for (uint32_t x = 0; x < kSize; ++x) {
      const float height = kTexel * (static_cast<float>(x) + 0.5f) - 0.32f;
      depths.push_back(0.5f - 0.5f * height);
    }
  std::vector<Float4> points;
  for (int i = -200; i <= 200; ++i) {
    const float x = 0.0015f * static_cast<float>(i);
    points.push_back({x, x, 0.003f, 0});
  }
  OpaqueShadowView view = viewFromAbove(false);
  const std::vector<float> acne = light(depths, view, points);
  EXPECT_GT(std::count_if(acne.begin(), acne.end(), [](float t) { return t < 0.9f; }), 200);
  // A texel's slope: what the four texels around a point are higher than it.
  view.bias = 1.01f * kTexel;
  for (const float t : light(depths, view, points)) EXPECT_EQ(t, 1);
  // And no more than that: half a texel deeper hair is in the shadow.
  for (Float4& p : points) p.y -= 2.02f * kTexel;
  for (const float t : light(depths, view, points)) EXPECT_EQ(t, 0);
}

TEST_P(OpaqueShadowMap, IsLitOutsideAndWhereNothingIsKnown) {
  const std::vector<float> covered(size_t{kSize} * kSize, 0.25f);
  const std::vector<Float4> outside = {{0.4f, 0, 0, 0},  {0, 0, -0.4f, 0},  {kNan, 0, 0, 0},
                                       {0, 0, kNan, 0},  {kInf, 0, 0, 0},   {0, 0, -kInf, 0},
                                       {1e30f, 0, 0, 0}, {0, 0.7f, 0, 0},   {0, 3, 0, 0},
                                       {0, kNan, 0, 0},  {-0.4f, -9, 0, 0}, {0, 0, 1e20f, 0}};
  for (const float t : light(covered, viewFromAbove(false), outside)) EXPECT_EQ(t, 1);
  // Its last texels fade into what is outside: the middle of a point on its border is lit.
  const float border = 0.5f * kTexel * static_cast<float>(kSize);
  for (const float along : {-0.213f, 0.0f, 0.1f}) {
    const std::vector<float> half = light(covered, viewFromAbove(false),
                                          {{border, 0, along, 0},
                                           {-border, 0, along, 0},
                                           {along, 0, border, 0},
                                           {along, 0, -border, 0}});
    for (const float t : half) EXPECT_NEAR(t, 0.5f, 1e-3f) << along;
  }
  // Behind the far plane there is shadow as well, but not of the empty background.
  EXPECT_EQ(light(covered, viewFromAbove(false), {{0, -5, 0, 0}})[0], 0);
  const std::vector<float> empty(size_t{kSize} * kSize, 1);
  EXPECT_EQ(light(empty, viewFromAbove(false), {{0, -5, 0, 0}})[0], 1);
  const std::vector<float> unknown(size_t{kSize} * kSize, kNan);
  EXPECT_EQ(light(unknown, viewFromAbove(false), {{0, -0.5f, 0, 0}})[0], 1);
  // Behind a light in perspective.
  OpaqueShadowView view = viewFromAbove(false);
  view.clipW = {0, -1, 0, 1};
  view.clipZ = {0, -1, 0, 0.9f};
  EXPECT_EQ(light(covered, view, {{0, 1.5f, 0, 0}})[0], 1);
  EXPECT_EQ(light(covered, view, {{0, -0.5f, 0, 0}})[0], 0);
}

TEST_P(OpaqueShadowMap, CopyHasTheBitsOfTheMapAndChangesNothingElse) {
  for (const uint32_t texels : {1u, 127u, 128u, 5000u}) {
    std::vector<float> depths;
    Random random(texels);
    for (uint32_t i = 0; i < texels; ++i) depths.push_back(static_cast<float>(random.unit()));
    depths[0] = std::numeric_limits<float>::quiet_NaN();
    const GuardedBuffer<float> from(gpu(), "depths", depths);
    const GuardedBuffer<uint32_t> to(gpu(), "words",
                                     std::vector<uint32_t>(texels + 2 * kAround, kPattern));
    PassList list;
    expectOk(detail::addOpaqueShadow(list,
                                     {.depth = from.id(), .words = texels, .firstWord = kAround},
                                     to.id(), texels + 2 * kAround));
    gpu().execute(list);
    const std::vector<uint32_t> words = to.read();
    for (uint32_t i = 0; i < words.size(); ++i) {
      const bool own = i >= kAround && i < kAround + texels;
      EXPECT_EQ(words[i], own ? std::bit_cast<uint32_t>(depths[i - kAround]) : kPattern) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, OpaqueShadowMap, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
