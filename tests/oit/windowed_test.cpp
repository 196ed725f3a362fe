// Transparency::kWindowed: the exact composite, in a known amount of memory.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "oit/tangle.h"

namespace pelage::test {
namespace {

using WindowedTransparency = TangleTest;

constexpr uint32_t kPixels = 64;

// Room for all fragments of a tangle.
TransparencySettings roomy() {
  TransparencySettings settings;
  settings.nodeCount = 1 << 17;
  return settings;
}

TEST_P(WindowedTransparency, IsTheCompositeOfAllFragmentsInOrder) {
  for (const float opacity : {0.33f, 0.6f, 1.0f}) {
    TangleRun scene(GetParam());
    scene.add({.opacity = opacity});
    for (const bool reversedDepth : {false, true}) {
      if (reversedDepth && opacity > 0.5f) continue;
      const View view = tangleView(kPixels, reversedDepth);
      const RenderedImage image = scene.render(view, roomy());
      const std::vector<ExactPixel> exact = scene.exact(view);
      const CompositeError error = compositeError(image, exact);
      double layers = 0;
      for (const ExactPixel& p : exact) layers += p.fragments;
      ASSERT_GT(error.pixels, kPixels * kPixels / 2);
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
      // Those whose alpha rounds to 0 are in the capture alone.
      EXPECT_NEAR(counters.fragments, fragments, 1e-3 * fragments);
    }
  }
}

TEST_P(WindowedTransparency, DoesNotDependOnTheOrderOfArrival) {  // K36
  const View view = tangleView(kPixels);
  tangleRun().add({});
  const RenderedImage image = tangleRun().render(view, roomy());
  TangleRun other(GetParam());
  other.add({.reversed = true});
  EXPECT_TRUE(sameBits(image, other.render(view, roomy())));
  // The next frame finds lists that were used before.
  EXPECT_TRUE(sameBits(image, tangleRun().render(view, roomy())));
}

TEST_P(WindowedTransparency, DoesNotDependOnTheOrderOfStrandsAtOnePlace) {  // K36
  const TangleDef def = {.strands = 20, .radius = 0.005f, .opacity = 0.6f};
  const View view = tangleView(kPixels);
  tangleRun().add(def, twins(tangle(def), false));
  const RenderedImage image = tangleRun().render(view, roomy());
  EXPECT_GT(std::count_if(image.pixels.begin(), image.pixels.end(),
                          [](const Float4& p) { return p.w > 0; }),
            400);
  TangleRun other(GetParam());
  other.add(def, twins(tangle(def), true));
  EXPECT_TRUE(sameBits(image, other.render(view, roomy())));
}

TEST_P(WindowedTransparency, KeepsThePictureWhereTheListsAreFull) {  // K35
  const View view = tangleView(kPixels);
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
  // What comes through is exact, so no pixel is emptied.
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
  const View whole = tangleView(kPixels);
  tangleRun().add({});
  const RenderedImage image = tangleRun().render(whole, roomy());
  View part = whole;
  part.x = 0;
  part.y = 0;
  // Odd sizes, and one pixel, in which thousands of thin layers are averaged.
  for (const uint32_t size : {kPixels - 5, 1u}) {
    part.width = part.height = size;
    const RenderedImage small = tangleRun().render(part, roomy());
    const CompositeError error = compositeError(small, tangleRun().exact(part));
    EXPECT_GE(error.psnr, size > 1 ? 64 : 32) << size;
  }
  EXPECT_TRUE(sameBits(image, tangleRun().render(whole, roomy())));
}

TEST_P(WindowedTransparency, StandsAlphasOfZeroAndOneAndThousandsOfLayers) {
  TangleDef def;
  def.strands = 200;
  def.opacity = 0;
  tangleRun().add(def);
  const View view = tangleView(kPixels);
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
    HairDef hairDef;
    hairDef.material = tangleMaterial({.opacity = opacity});
    hairDef.material.fiberRadius = 0.01f;
    hairDef.settings.gravity = {0, 0, 0};
    scene.run.add(stack, hairDef);
    scene.run.step();
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
  View view = tangleView(kPixels);
  // In the middle of the hair: strands behind the eye, through the near plane and across it.
  view.eye = {0, 0, 0};
  for (const bool reversedDepth : {false, true}) {
    view.worldToClip =
        lookAt(view.eye, {0, 0, -1}, {0, 1, 0}, 1.5f, 1, 0.001f, 1.0f, reversedDepth);
    view.reversedDepth = reversedDepth;
    const RenderedImage image = tangleRun().render(view, roomy());
    EXPECT_TRUE(allFinite(image));
    const CompositeError error = compositeError(image, tangleRun().exact(view));
    EXPECT_GE(error.psnr, 60);
  }
}

TEST_P(WindowedTransparency, RefusesViewsThatHaveNoInverse) {
  tangleRun().add({.strands = 2});
  View view = tangleView(kPixels);
  for (const float broken :
       {0.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    view.worldToClip.rows[3] = {broken, broken, broken, broken};
    tangleRun().lists.clear();
    const Result<void> drawn =
        tangleRun().run.scene.draw(view, tangleLights(), {}, tangleRun().lists);
    ASSERT_FALSE(drawn);
    EXPECT_NE(drawn.error().message.find("worldToClip"), std::string::npos);
  }
  TransparencySettings tight;
  tight.maxBytes = 1000;
  const Result<void> drawn =
      tangleRun().run.scene.draw(tangleView(kPixels), tangleLights(), tight, tangleRun().lists);
  ASSERT_FALSE(drawn);
  EXPECT_NE(drawn.error().message.find("maxBytes is 1000"), std::string::npos);
}

TEST_P(WindowedTransparency, StandsPositionsAndTangentsThatAreNotNumbers) {
  tangleRun().add({.strands = 100});
  const View view = tangleView(kPixels);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float far = std::numeric_limits<float>::infinity();
  std::vector<Float4> positions = tangleRun().run.positions(tangleRun().hair());
  std::vector<Float4> tangents(positions.size(), {nan, 0, far, 0});
  for (size_t i = 0; i < positions.size(); i += 5) positions[i] = {nan, far, -far, nan};
  for (size_t i = 0; i < 6; ++i) positions[i] = {nan, nan, nan, nan};  // a whole strand
  tangleRun().lists.assign(1, {});
  addUpload(tangleRun().lists[0], tangleRun().hair().buffers().positions,
            std::as_bytes(std::span(positions)));
  addUpload(tangleRun().lists[0], tangleRun().hair().buffers().tangents,
            std::as_bytes(std::span(tangents)));
  expectOk(tangleRun().run.scene.draw(view, tangleLights(), {}, tangleRun().lists));
  const auto image = tangleRun().renderLists(view);
  ASSERT_TRUE(image);
  EXPECT_TRUE(allFinite(*image));
  const auto covered = std::count_if(image->pixels.begin(), image->pixels.end(),
                                     [](const Float4& p) { return p.w > 0; });
  EXPECT_GT(covered, 500) << "the finite vertices are drawn";
}

INSTANTIATE_TEST_SUITE_P(All, WindowedTransparency, testing::ValuesIn(kApis),
                         [](const auto& api) { return std::string(apiName(api.param)); });

}  // namespace
}  // namespace pelage::test
