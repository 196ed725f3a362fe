// Transparency::kWindowed: the exact composite, in a known amount of memory.
#include <gtest/gtest.h>

#include "oit/tangle.h"

namespace pelage::test {
namespace {

using WindowedTransparency = TangleTest;

constexpr uint32_t kListPixels = 64;

// Room for all fragments of a tangle.
TransparencySettings roomy() { return {.nodeCount = 1 << 17}; }

TEST_P(WindowedTransparency, IsTheCompositeOfAllFragmentsInOrder) {
  for (const float opacity : {0.33f, 0.6f, 1.0f}) {
    TangleRun scene(GetParam());
    scene.add({.opacity = opacity});
    for (const bool reversedDepth : {false, true}) {
      if (reversedDepth && opacity > 0.5f) continue;
      const View view = tangleView(kListPixels, reversedDepth);
      const RenderedImage image = scene.render(view, roomy());
      const std::vector<ExactPixel> exact = scene.exact(view);
      const CompositeError error = compositeError(image, exact);
      double layers = 0;
      for (const ExactPixel& p : exact) layers += p.fragments;
      ASSERT_GT(error.pixels, kListPixels * kListPixels / 2);
      layers /= static_cast<double>(error.pixels);
      EXPECT_GT(layers, 10);
      EXPECT_GE(error.psnr, 64) << "opacity " << opacity;
      // With less in front of them, what single fragments are rounded by shows.
      EXPECT_LE(error.worst, (opacity < 0.5f ? 0.6 : 1.5) / 255) << "opacity " << opacity;
      EXPECT_LE(error.share, opacity < 0.5f ? 0 : 1e-3) << "opacity " << opacity;
      std::cout << apiName(GetParam()) << " opacity " << opacity
                << (reversedDepth ? " reversed" : "") << ": " << layers << " layers, PSNR "
                << error.psnr << " dB, worst " << 255 * error.worst << "/255\n";
      const TransparencyCounters counters = scene.counters(kMaxListNodes);
      double fragments = 0;
      for (const ExactPixel& p : exact) fragments += p.fragments;
      // Fragments whose alpha rounds to 0 are in the capture alone.
      EXPECT_NEAR(counters.fragments, fragments, 1e-3 * fragments);
    }
  }
}

TEST_P(WindowedTransparency, DoesNotDependOnTheOrderOfArrival) {  // K36
  expectNoOrderOfStrands({}, tangleView(kListPixels), {roomy()});
}

TEST_P(WindowedTransparency, DoesNotDependOnTheOrderOfStrandsAtOnePlace) {  // K36
  const RenderedImage image = expectNoOrderOfTwins(
      {.strands = 20, .radius = 0.005f, .opacity = 0.6f}, tangleView(kListPixels), {roomy()});
  EXPECT_GT(coveredPixels(image), 400u);
}

TEST_P(WindowedTransparency, KeepsThePictureWhereTheListsAreFull) {  // K35
  const View view = tangleView(kListPixels);
  tangleRun().add({});
  const RenderedImage whole = tangleRun().render(view, roomy());
  const std::vector<ExactPixel> exact = tangleRun().exact(view);
  const TransparencyCounters all = tangleRun().counters(kMaxListNodes);
  EXPECT_EQ(all.spilled, 0u);
  EXPECT_GT(all.tiles, 32u);

  TransparencySettings settings = roomy();
  settings.nodeCount = static_cast<uint32_t>(0.95 * all.fragments);
  const RenderedImage image = tangleRun().render(view, settings);
  const TransparencyCounters counters = tangleRun().counters(settings.nodeCount);
  EXPECT_EQ(counters.fragments, all.fragments);
  EXPECT_EQ(counters.spilled, all.fragments - settings.nodeCount);
  const CompositeError error = compositeError(image, exact);
  EXPECT_GE(error.psnr, 33);
  // The transmittance is exact, so no pixel is emptied.
  for (size_t i = 0; i < exact.size(); ++i)
    ASSERT_NEAR(static_cast<double>(image.pixels[i].w), 1 - exact[i].transmittance, 0.01);
  settings.nodeCount = growNodes(counters, settings.nodeCount);
  EXPECT_TRUE(sameBits(whole, tangleRun().render(view, settings)));

  // One node, and then none that a tail could help.
  for (const bool tail : {true, false}) {
    settings.nodeCount = 1;
    settings.spillTail = tail;
    const RenderedImage little = tangleRun().render(view, settings);
    EXPECT_TRUE(allFinite(little));
    EXPECT_EQ(tangleRun().counters(1).spilled, all.fragments - 1);
  }
}

TEST_P(WindowedTransparency, DrawsIntoAPartOfTheTarget) {  // K41
  const View whole = tangleView(kListPixels);
  tangleRun().add({});
  const RenderedImage image = tangleRun().render(whole, roomy());
  View part = whole;
  part.x = 0;
  part.y = 0;
  // Odd sizes, and one pixel, in which thousands of thin layers are averaged.
  for (const uint32_t size : {kListPixels - 5, 1u}) {
    part.width = part.height = size;
    const RenderedImage small = tangleRun().render(part, roomy());
    const CompositeError error = compositeError(small, tangleRun().exact(part));
    EXPECT_GE(error.psnr, size > 1 ? 64 : 32) << size;
  }
  EXPECT_TRUE(sameBits(image, tangleRun().render(whole, roomy())));
}

TEST_P(WindowedTransparency, StandsAlphasOfZeroAndOneAndThousandsOfLayers) {
  tangleRun().add({.strands = 200, .opacity = 0});
  const View view = tangleView(kListPixels);
  for (const Float4& p : tangleRun().render(view, roomy()).pixels) EXPECT_EQ(p, Float4{});

  // 2000 strands one behind the other, each with a little of the light.
  HairAsset stack;
  stack.strandCount = 2000;
  stack.verticesPerStrand = 2;
  for (uint32_t s = 0; s < stack.strandCount; ++s) {
    const float z = -1e-4f * static_cast<float>(s);
    stack.positions.push_back({-0.05f, 0, z, 0});
    stack.positions.push_back({0.05f, 0, z, 1});
  }
  expectOk(stack.process());
  for (const float opacity : {0.002f, 1.0f}) {
    TangleRun scene(GetParam());
    scene.add({.radius = 0.01f, .opacity = opacity}, stack);
    const View narrow = tangleView(12);
    const RenderedImage image = scene.render(narrow, roomy());
    const std::vector<ExactPixel> exact = scene.exact(narrow);
    EXPECT_GE(exact[6 * 12 + 6].fragments, 2000u);
    // Beyond 512 layers the rest is averaged, with alphas rounded to 1e-4.
    const CompositeError error = compositeError(image, exact);
    EXPECT_LE(error.worst, 0.05) << "opacity " << opacity;
  }
}

TEST_P(WindowedTransparency, StandsStrandsAtAndBehindTheEye) {
  tangleRun().add({.strands = 300});
  for (const bool reversedDepth : {false, true}) {
    const View view = viewFromInside(kListPixels, reversedDepth);
    const RenderedImage image = tangleRun().render(view, roomy());
    EXPECT_TRUE(allFinite(image));
    const CompositeError error = compositeError(image, tangleRun().exact(view));
    EXPECT_GE(error.psnr, 60);
  }
}

TEST_P(WindowedTransparency, StandsPositionsAndTangentsThatAreNotNumbers) {
  tangleRun().add({.strands = 100});
  const RenderedImage image = tangleRun().renderSpoiled(tangleView(kListPixels), {});
  EXPECT_TRUE(allFinite(image));
  EXPECT_GT(coveredPixels(image), 500u) << "the finite vertices are drawn";
}

INSTANTIATE_TEST_SUITE_P(All, WindowedTransparency, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
