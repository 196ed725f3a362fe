// Every kind of transparency in targets of odd kinds: a viewport that does not begin at the corner,
// one pixel, 8192 columns.
#include <gtest/gtest.h>

#include <cmath>

#include "oit/shared_tangle.h"

namespace pelage::test {
namespace {

class TransparencyTargets : public SharedTangleTest<> {
 protected:
  void fill(TangleRun& run) override { run.add({.strands = 500}); }
  void SetUp() override {
    SharedTangleTest::SetUp();
    if (hasDevice()) tangleRun().hair().visible = true;
  }
  RenderedImage render(TangleRun& scene, const Method& method, View view,
                       RenderTargetDef target = {}) {
    view.samples = target.samples = method.samples;
    return scene.render(view, {.method = method.transparency, .nodeCount = 1 << 16}, target);
  }
};

TEST_P(TransparencyTargets, HaveThePictureWhereTheViewportIs) {  // K41
  View view = tangleView(1);
  view.width = 41;
  view.height = 35;
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const RenderedImage image = render(tangleRun(), method, view);
    View moved = view;
    moved.x = 19;
    moved.y = 6;
    const RenderTargetDef target = {
        .width = 77, .height = 58, .area = {19, 6, view.width, view.height}};
    const RenderedImage inside = render(tangleRun(), method, moved, target);
    uint32_t covered = 0, off = 0;
    for (uint32_t y = 0; y < target.height; ++y) {
      for (uint32_t x = 0; x < target.width; ++x) {
        const Float4& seen = inside.pixels[y * target.width + x];
        const uint32_t u = x - 19, v = y - 6;  // beyond the view to the left and above, too
        if (u >= view.width || v >= view.height) {
          ASSERT_EQ(seen, Float4{}) << method.name << " at " << x << " " << y;
          continue;
        }
        covered += seen.w > 0 ? 1 : 0;
        off += maxDifference(seen, image.pixels[v * view.width + u]) <= 1.0f / 255 ? 0 : 1;
      }
    }
    EXPECT_GT(covered, 300u) << method.name;
    // Corners are rounded elsewhere, which moves an edge of a ribbon here and there.
    EXPECT_LE(off, 14u) << method.name;
  }
}

TEST_P(TransparencyTargets, HaveThePictureInTheLastOf8192Columns) {
  // 64 pixels a metre.
  constexpr uint32_t kWide = 8192, kHigh = 16, kPart = 64;
  HairAsset asset;
  asset.verticesPerStrand = 4;
  pelage::Random random(3);
  const auto add = [&](float x, float y, float toX, float toY) {
    for (int v = 0; v < 4; ++v) {
      const float share = static_cast<float>(v) / 3;
      asset.positions.push_back({x + share * (toX - x), y + share * (toY - y),
                                 0.3f + 0.01f * static_cast<float>(asset.strandCount),
                                 v < 2 ? 0.0f : 1.0f});
    }
    ++asset.strandCount;
  };
  add(-63.9f, -0.1f, 63.95f, 0.08f);
  add(63.9f, -0.07f, -63.9f, 0.02f);
  for (int i = 0; i < 12; ++i) {
    const auto across = [&] { return 63.02f + 0.96f * random.uniform(); };
    const auto down = [&] { return 0.22f * random.uniform() - 0.11f; };
    add(across(), down(), across(), down());
  }
  expectOk(asset.process());
  tangleRun().hair().visible = false;
  HairObject& strands = tangleRun().run.add(asset, tangleHair({.radius = 0.02f, .opacity = 0.5f}));
  tangleRun().run.step();

  View wide;
  wide.worldToClip.rows[0] = {1.0f / 64, 0, 0, 0};
  wide.worldToClip.rows[1] = {0, 8, 0, 0};
  wide.eye = {0, 0, -1000};
  wide.width = kWide;
  wide.height = kHigh;
  // The last columns alone.
  View part = wide;
  part.worldToClip.rows[0] = {2, 0, 0, -127};
  part.width = kPart;
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const RenderedImage whole = render(tangleRun(), method, wide);
    const RenderedImage last = render(tangleRun(), method, part);
    EXPECT_TRUE(allFinite(whole)) << method.name;
    uint32_t covered = 0, off = 0;
    double sums[2] = {0, 0};
    for (uint32_t y = 0; y < kHigh; ++y) {
      for (uint32_t x = 0; x < kPart; ++x) {
        const Float4& seen = whole.pixels[y * kWide + kWide - kPart + x];
        const Float4& expected = last.pixels[y * kPart + x];
        covered += expected.w > 0 ? 1 : 0;
        sums[0] += static_cast<double>(seen.w);
        sums[1] += static_cast<double>(expected.w);
        off += maxDifference(seen, expected) <= 4.0f / 255 ? 0 : 1;
      }
    }
    EXPECT_GT(covered, kPart * kHigh / 8) << method.name;
    // The dither goes by the pixel's place, which is another one.
    if (method.transparency == Transparency::kStochastic) {
      EXPECT_NEAR(sums[0] / sums[1], 1, 0.08) << method.name;
    } else {
      EXPECT_LE(off, kPart * kHigh / 100) << method.name;
    }
  }
  strands.visible = false;
}

TEST_P(TransparencyTargets, MayHaveOnePixel) {
  const RenderedImage exact = render(tangleRun(), kMethods[2], tangleView(1));
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const RenderedImage image = render(tangleRun(), method, tangleView(1));
    EXPECT_TRUE(allFinite(image)) << method.name;
    const float alpha = image.pixels[0].w;
    if (method.transparency == Transparency::kAlphaTest ||
        method.transparency == Transparency::kStochastic) {
      // These two methods cover whole samples of the pixel, by chance.
      const float covered = alpha * static_cast<float>(method.samples);
      EXPECT_EQ(covered, std::round(covered)) << method.name;
      EXPECT_TRUE(alpha >= 0 && alpha <= 1) << method.name << ": " << alpha;
    } else {
      EXPECT_NEAR(alpha, exact.pixels[0].w, 0.02f) << method.name;
    }
  }
  EXPECT_GT(exact.pixels[0].w, 0.4f);
}

TEST_P(TransparencyTargets, CostAboutTheWorkThatIsPredicted) {
  const View view = tangleView(96);
  const TransparencyWork predicted = tangleRun().run.scene.predictWork(view);
  for (const Transparency method : {Transparency::kWindowed, Transparency::kTiles}) {
    TransparencySettings settings = {.method = method, .nodeCount = 1 << 17};
    tangleRun().render(view, settings);
    const TransparencyCounters counted = tangleRun().counters(settings.nodeCount);
    const double ratio = predicted.fragments / counted.fragments;
    std::cout << "predicted " << ratio << " of the work, " << predicted.tiles / counted.tiles
              << " of the tiles\n";
    EXPECT_NEAR(std::log(ratio), 0, std::log(2.0));
    EXPECT_NEAR(std::log(predicted.tiles / counted.tiles), 0, std::log(2.0));
    // From then on it is what was counted.
    EXPECT_EQ(refineWork(predicted, method, counted).tiles, counted.tiles);
  }
}

TEST_P(TransparencyTargets, HaveNoNumberlessPixelsWithTheEyeAmongOpaqueStrands) {
  for (const bool reversedDepth : {false, true}) {
    const View view = viewFromInside(24, reversedDepth);
    for (const Method& method : {kMethods[0], kMethods[1]}) {
      if (!hasTarget(method)) continue;
      const RenderedImage image = render(tangleRun(), method, view);
      EXPECT_TRUE(allFinite(image)) << method.name;
      EXPECT_GT(coverage(image), 2) << method.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, TransparencyTargets, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
