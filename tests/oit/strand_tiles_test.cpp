// Transparency::kTiles: the picture of the exact composite without rasteriser and lists.
#include <gtest/gtest.h>

#include "oit/tangle.h"
#include "support/errors.h"

namespace pelage::test {
namespace {

constexpr uint32_t kTilePixels = 48;

TransparencySettings lists() { return {.nodeCount = 1 << 18}; }
TransparencySettings tiles() { return {.method = Transparency::kTiles}; }

/// Mean of the alphas.
double meanAlpha(const RenderedImage& image) {
  return coverage(image) / static_cast<double>(image.pixels.size());
}

class StrandTiles : public TangleTest {
 protected:
  /// Both methods draw the same.
  void expectSame(TangleRun& scene, const View& view, const std::string& what,
                  double leastCovered) {
    const RenderedImage exact = scene.render(view, lists());
    const RenderedImage image = scene.render(view, tiles());
    EXPECT_TRUE(allFinite(image)) << what;
    EXPECT_GT(meanAlpha(exact), leastCovered) << what;
    const double worst = maxDifference(exact, image);
    EXPECT_LE(worst, 1.0 / 255) << what;
    std::cout << apiName(GetParam()) << " " << what << ": worst " << 255 * worst << "/255\n";
  }

  /// Pixels of many layers are the composite of all fragments. They are few, as llvmpipe ends the
  /// loops of a thread after 65,535 steps.
  void expectExact(TangleRun& scene, float opacity) {
    const View view = tangleView(1);
    scene.render(view, lists());
    const std::vector<ExactPixel> exact = scene.exact(view);
    const RenderedImage image = scene.render(view, tiles());
    double worst = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
      EXPECT_GT(exact[i].fragments, 768u) << "as many as group memory has room for";
      const Float4& pixel = image.pixels[i];
      worst = std::max({worst, std::abs(double{pixel.x} - exact[i].color[0]),
                        std::abs(double{pixel.z} - exact[i].color[2]),
                        std::abs(double{pixel.w} - (1 - exact[i].transmittance))});
    }
    std::cout << apiName(GetParam()) << " opacity " << opacity << ": " << exact[0].fragments
              << " fragments, alpha " << image.pixels[0].w << ", worst " << 255 * worst << "/255\n";
    EXPECT_LE(worst, 2.0 / 255);
  }
};

TEST_P(StrandTiles, AreThePictureOfTheListsForEveryWidth) {
  struct Case {
    float radius, opacity;
    bool reversed;
    uint32_t strands;
    double covered;
  };
  tangleRun().add({.strands = 500});
  HairObject& hair = tangleRun().hair();
  // 0.1 pixels, 0.6 pixels and 20 pixels wide in the middle of the picture.
  for (const Case& c : {Case{0.0002f, 1.0f, false, 500, 0.05}, Case{0.0012f, 0.33f, true, 500, 0.2},
                        Case{0.0012f, 1.0f, false, 500, 0.2}, Case{0.04f, 0.5f, true, 40, 0.6}}) {
    hair.material.fiberRadius = c.radius;
    hair.material.opacity = c.opacity;
    hair.drawnStrands = c.strands;
    expectSame(tangleRun(), tangleView(kTilePixels, c.reversed),
               "radius " + std::to_string(c.radius), c.covered);
  }
}

TEST_P(StrandTiles, AreThePictureOfTheListsAtAndBehindTheEye) {
  tangleRun().add({.strands = 300});
  for (const bool reversedDepth : {false, true}) {
    expectSame(tangleRun(), viewFromInside(kTilePixels, reversedDepth),
               reversedDepth ? "eye reversed" : "eye", 0.1);
  }
  // Long segments, many of them from before the eye to behind it.
  TangleRun scene(GetParam());
  HairAsset needles;
  needles.strandCount = 90;
  needles.verticesPerStrand = 2;
  pelage::Random random(9);
  const auto within = [&](float range) { return range * (2 * random.uniform() - 1); };
  for (uint32_t i = 0; i < needles.strandCount; ++i) {
    needles.positions.push_back({within(0.1f), within(0.1f), -0.02f - 0.2f * random.uniform(), 0});
    needles.positions.push_back({within(0.2f), within(0.2f), within(0.3f), 1});
  }
  expectOk(needles.process());
  scene.add({.opacity = 0.5f}, needles);
  for (const bool reversedDepth : {false, true}) {
    expectSame(scene, viewFromInside(kTilePixels, reversedDepth, 0.02f),
               reversedDepth ? "needles reversed" : "needles", 0.1);
  }
  // Planes that cut many strands, near and far.
  const View planes = cameraView(
      {.eye = {0, 0, 0.5f}, .width = kTilePixels, .nearPlane = 0.48f, .farPlane = 0.53f});
  expectSame(tangleRun(), planes, "planes", 0.03);
}

TEST_P(StrandTiles, AreThePictureOfTheListsForEverySizeOfTheView) {
  tangleRun().add({.strands = 300});
  for (const uint32_t size : {1u, 9u, 37u}) {
    View view = tangleView(kTilePixels);
    view.width = size;
    view.height = size + size / 2;
    expectSame(tangleRun(), view, std::to_string(size) + " pixels", 0.01);
  }
}

/// A group of threads takes one pixel of these, and otherwise 16 of a tile.
TEST_P(StrandTiles, AreThePictureOfTheListsWhereFewTilesHaveManyFragments) {
  tangleRun().add({.strands = 1200, .radius = 0.004f, .opacity = 0.1f});
  const View view = tangleView(kTilePixels);
  tangleRun().render(view, lists());
  uint64_t fragments = 0;
  for (const ExactPixel& pixel : tangleRun().exact(view)) fragments += pixel.fragments;
  EXPECT_GT(fragments, 12u * view.width * view.height);
  expectSame(tangleRun(), view, "many fragments", 0.2);
}

TEST_P(StrandTiles, AreExactForMoreLayersThanAGroupHasRoomFor) {
  // One alone in front, so that the others have few of the bins of a histogram of depths.
  HairAsset front;
  front.strandCount = 1;
  front.verticesPerStrand = 2;
  front.positions = {{-0.05f, 0, 0.38f, 0}, {0.05f, 0, 0.38f, 1}};
  expectOk(front.process());
  tangleRun().add({.radius = 0.01f}, front);
  // So faint that all of them are visible, and so opaque that only the nearest ones are.
  tangleRun().add({.strands = 2500, .radius = 0.03f});
  for (const float opacity : {0.005f, 0.05f, 0.9f}) {
    tangleRun().hair().material.opacity = opacity;
    expectExact(tangleRun(), opacity);
  }
}

TEST_P(StrandTiles, AreExactForMoreTiesThanAGroupHasRoomFor) {
  // Strands in a plane in front of the eye have one depth. They look the same, so that the order of
  // them, which is that of their indices, changes no picture.
  HairAsset plane;
  plane.strandCount = 1100;
  plane.verticesPerStrand = 2;
  pelage::Random random(12);
  for (uint32_t i = 0; i < plane.strandCount; ++i) {
    const float x = 0.1f * (2 * random.uniform() - 1);
    plane.positions.push_back({x, -0.5f, 0, 0});
    plane.positions.push_back({x, 0.5f, 0, 1});
  }
  expectOk(plane.process());
  tangleRun().add({.radius = 0.2f}, plane);
  for (const float opacity : {0.001f, 0.02f}) {
    tangleRun().hair().material.opacity = opacity;
    expectExact(tangleRun(), opacity);
  }
}

TEST_P(StrandTiles, DrawAllKindsOfHairObjects) {
  HairAsset asset = tangle({.strands = 60});
  pelage::Random random(5);
  for (uint32_t i = 0; i < asset.strandCount; ++i)
    asset.strandUv.push_back({random.uniform(), random.uniform()});
  for (uint32_t i = 0; i < asset.strandCount; ++i)
    asset.strandThickness.push_back(0.5f + random.uniform());
  for (size_t i = 0; i < asset.positions.size(); ++i)
    asset.vertexColor.push_back(
        {1, random.uniform(), random.uniform(), 0.5f + 0.5f * random.uniform()});
  const std::vector<Float4> texels = {
      {1, 0.2f, 0.1f, 1}, {0.3f, 1, 0.2f, 0.8f}, {0.2f, 0.3f, 1, 0.5f}, {1, 1, 0.5f, 1}};
  HairDef def = tangleHair({.opacity = 0.5f});
  const Result<std::vector<FollowHair>> follow =
      required(asset.generateFollowHairs({.countPerGuide = 6, .maxRadius = 0.01f}));
  def.followHairs = *follow;
  def.baseTexture = {2, 2, texels};
  HairObject& first = tangleRun().run.add(asset, def);
  first.drawnShare = 0.7f;
  tangleRun().add({.strands = 200, .seed = 11});
  tangleRun().hair().material.model = ShadingModel::kFiber;
  expectSame(tangleRun(), tangleView(kTilePixels), "two objects", 0.2);
}

TEST_P(StrandTiles, AreHiddenByWhatIsOpaque) {
  tangleRun().add({.strands = 250, .opacity = 0.4f});
  HairAsset bars;
  bars.verticesPerStrand = 2;
  for (const float x : {-0.06f, 0.0f, 0.06f}) {
    bars.positions.push_back({x, -0.08f, 0.02f, 0});
    bars.positions.push_back({x + 0.02f, 0.08f, -0.02f, 1});
    ++bars.strandCount;
  }
  expectOk(bars.process());
  HairDef def;
  def.material.fiberRadius = 0.012f;
  def.settings.gravity = {0, 0, 0};
  HairObject& opaque = tangleRun().run.add(bars, def);
  tangleRun().run.step();
  for (const bool reversedDepth : {false, true}) {
    View view = tangleView(kTilePixels - 5, reversedDepth);
    RenderTargetDef target = {.width = view.width, .height = view.height};
    if (reversedDepth) {
      // The buffer of depths has the viewport's pixels.
      view.x = 6;
      view.y = 11;
      target.area = {6, 11, view.width, view.height};
      target.width += 9;
      target.height += 13;
    }
    target.clearDepth = reversedDepth ? 0.0f : 1.0f;
    target.depthCopy = tangleRun().resources().add(
        {.name = "depth", .size = uint64_t{view.width} * view.height * 4, .stride = 4});
    const auto render = [&](TransparencySettings settings) {
      std::vector<PassList> drawn;
      const TransparencySettings solid = {.method = Transparency::kStochastic};
      Scene& scene = tangleRun().run.scene;
      opaque.visible = true;
      tangleRun().hair().visible = false;
      expectOk(scene.draw(view, tangleLights(), solid, drawn));
      opaque.visible = false;
      tangleRun().hair().visible = true;
      expectOk(scene.draw(view, tangleLights(), settings, drawn));
      return imageOf(tangleRun().run.renderLists(drawn, target), target);
    };
    const RenderedImage exact = render(lists());
    TransparencySettings settings = tiles();
    const RenderedImage before = render(settings);
    settings.opaqueDepth = target.depthCopy;
    const RenderedImage image = render(settings);
    EXPECT_GT(maxDifference(exact, before), 0.03) << "some hair is behind the bars";
    EXPECT_LE(maxDifference(exact, image), 1.0 / 255);

    settings.opaqueDepth = tangleRun().resources().add({.name = "small", .size = 64, .stride = 4});
    std::vector<PassList> none;
    expectError(tangleRun().run.scene.draw(view, tangleLights(), settings, none),
                "opaqueDepth has 64 bytes");
  }
}

TEST_P(StrandTiles, DoNotDependOnTheOrderOfStrands) {  // K36
  expectNoOrderOfStrands({.strands = 300}, tangleView(kTilePixels), {tiles()});
}

TEST_P(StrandTiles, DoNotDependOnTheOrderOfStrandsAtOnePlace) {  // K36
  const RenderedImage image = expectNoOrderOfTwins(
      {.strands = 20, .radius = 0.005f, .opacity = 0.6f}, tangleView(kTilePixels), {tiles()});
  EXPECT_GT(meanAlpha(image), 0.1);
}

TEST_P(StrandTiles, StandAlphasOfZeroAndOneAndHundredsOfLayers) {
  tangleRun().add({.strands = 100, .opacity = 0});
  for (const Float4& p : tangleRun().render(tangleView(kTilePixels), tiles()).pixels)
    EXPECT_EQ(p, Float4{});
  // They fill whole tiles.
  HairAsset stack;
  stack.strandCount = 240;
  stack.verticesPerStrand = 2;
  pelage::Random random(3);
  for (uint32_t s = 0; s < stack.strandCount; s += 2) {
    const float left = -0.2f * random.uniform(), right = -0.2f * random.uniform();
    // Two at the same place: they tie in depth and in all they are.
    for (uint32_t twin = 0; twin < 2; ++twin) {
      stack.positions.push_back({-0.4f, 0, left, 0});
      stack.positions.push_back({0.4f, 0, right, 1});
    }
  }
  expectOk(stack.process());
  for (const float opacity : {0.008f, 1.0f}) {
    TangleRun scene(GetParam());
    scene.add({.radius = 0.3f, .opacity = opacity}, stack);
    scene.hair().material.tipRadiusRatio = 1;
    const View view = tangleView(8);
    scene.render(view, lists());
    const std::vector<ExactPixel> exact = scene.exact(view);
    EXPECT_GE(exact[35].fragments, 240u);
    // So many small alphas lose some light in their rounding, in lists as well.
    EXPECT_LE(compositeError(scene.render(view, tiles()), exact).worst, 2.5 / 255)
        << "opacity " << opacity;
  }
}

TEST_P(StrandTiles, LeaveTilesEmptyWithoutRoomAndSayHowMuchTheyNeed) {
  const View view = tangleView(kTilePixels);
  tangleRun().add({.strands = 300});
  const RenderedImage whole = tangleRun().render(view, tiles());
  const TransparencyCounters all = tangleRun().counters(kMaxListNodes);
  EXPECT_EQ(all.spilled, 0u);
  EXPECT_GT(all.fragments, 1000u);
  EXPECT_GT(all.tiles, 20u);

  TransparencySettings settings = tiles();
  settings.nodeCount = all.fragments / 2;
  const RenderedImage half = tangleRun().render(view, settings);
  EXPECT_EQ(tangleRun().counters(settings.nodeCount).spilled, all.fragments - settings.nodeCount);
  uint32_t same = 0, empty = 0;
  for (size_t i = 0; i < half.pixels.size(); ++i) {
    same += half.pixels[i] == whole.pixels[i] ? 1 : 0;
    empty += half.pixels[i] == Float4{} ? 1 : 0;
    ASSERT_TRUE(half.pixels[i] == whole.pixels[i] || half.pixels[i] == Float4{}) << i;
  }
  EXPECT_GT(empty, kTilePixels * kTilePixels / 4);
  EXPECT_GT(same, kTilePixels * kTilePixels / 4);
  EXPECT_TRUE(sameBits(half, tangleRun().render(view, settings)));

  settings.nodeCount = 1;
  for (const Float4& p : tangleRun().render(view, settings).pixels) EXPECT_EQ(p, Float4{});
  const TransparencyCounters one = tangleRun().counters(1);
  EXPECT_EQ(one.spilled, all.fragments - 1);
  settings.nodeCount = growNodes(one, 1);
  EXPECT_TRUE(sameBits(whole, tangleRun().render(view, settings)));
}

TEST_P(StrandTiles, AreTheSameInRounds) {
  const View view = tangleView(kTilePixels);
  tangleRun().add({.strands = 300});
  const RenderedImage whole = tangleRun().render(view, tiles());
  const uint32_t fragments = tangleRun().counters(kMaxListNodes).fragments;
  for (const double share : {0.9, 0.5, 0.2}) {
    TransparencySettings settings = tiles();
    settings.nodeCount = fragments;
    const uint64_t all =
        required(planTransparency(kTilePixels, kTilePixels, settings, 1800))->bytes;
    settings.maxBytes = all - static_cast<uint64_t>(24 * (1 - share) * fragments);
    const auto plan = required(planTransparency(kTilePixels, kTilePixels, settings, 1800));
    EXPECT_GE(plan->rounds, share > 0.5 ? 2u : static_cast<uint32_t>(1 / share));
    EXPECT_LE(plan->bytes, settings.maxBytes);
    EXPECT_EQ(plan->nodeCount, fragments);
    EXPECT_TRUE(sameBits(whole, tangleRun().render(view, settings))) << share;
    EXPECT_EQ(tangleRun().counters(plan->nodeCount).spilled, 0u);
  }
  // More rounds than there are: the last tiles are empty, the others are whole.
  TransparencySettings settings = tiles();
  settings.nodeCount = fragments;
  const uint64_t all = required(planTransparency(kTilePixels, kTilePixels, settings, 1800))->bytes;
  settings.maxBytes = all - static_cast<uint64_t>(24 * 0.96 * fragments);
  const auto plan = required(planTransparency(kTilePixels, kTilePixels, settings, 1800));
  EXPECT_EQ(plan->rounds, 16u);
  EXPECT_LT(plan->nodeCount, fragments);
  const RenderedImage part = tangleRun().render(view, settings);
  uint32_t empty = 0;
  for (size_t i = 0; i < part.pixels.size(); ++i) {
    empty += part.pixels[i] == Float4{} ? 1 : 0;
    ASSERT_TRUE(part.pixels[i] == whole.pixels[i] || part.pixels[i] == Float4{}) << i;
  }
  EXPECT_LT(empty, part.pixels.size());
  EXPECT_GT(tangleRun().counters(plan->nodeCount).spilled, 0u);
}

TEST_P(StrandTiles, StandPositionsAndTangentsThatAreNotNumbers) {
  tangleRun().add({.strands = 100});
  const View view = tangleView(kTilePixels);
  const RenderedImage exact = tangleRun().renderSpoiled(view, lists());
  const RenderedImage image = tangleRun().renderSpoiled(view, tiles());
  EXPECT_TRUE(allFinite(image));
  EXPECT_GT(meanAlpha(exact), 0.01) << "the finite vertices are drawn";
  EXPECT_LE(maxDifference(exact, image), 1.0 / 255);
  // So far away that places on the screen and their products have no floats.
  EXPECT_TRUE(allFinite(tangleRun().renderSpoiled(view, tiles(), true)));
}

TEST_P(StrandTiles, SayWhichCapIsTooSmall) {
  tangleRun().add({.strands = 20});
  const auto draw = [&](const TransparencySettings& settings) {
    std::vector<PassList> drawn;
    return tangleRun().run.scene.draw(tangleView(kTilePixels), tangleLights(), settings, drawn);
  };
  expectError(draw({.maxBytes = 1000}), "maxBytes is 1000");
  TransparencySettings settings = tiles();
  settings.maxBytes = 1000;
  expectError(draw(settings), "maxBytes is 1000");
  settings = tiles();
  settings.maxBufferBytes = 1000;
  expectError(draw(settings), "maxBufferBytes is 1000");

  const auto plan = required(planTransparency(kTilePixels, kTilePixels, tiles(), 20 * 6));
  settings = tiles();
  settings.maxBytes = plan->bytes;
  expectOk(draw(settings));
  EXPECT_EQ(plan->rounds, 1u);
  settings.maxBytes = plan->bytes - 2400;
  const auto less = required(planTransparency(kTilePixels, kTilePixels, settings, 20 * 6));
  EXPECT_EQ(less->roundCapacity, plan->nodeCount - 100);
  EXPECT_EQ(less->rounds, 2u);
  EXPECT_EQ(less->nodeCount, plan->nodeCount);
}

INSTANTIATE_TEST_SUITE_P(All, StrandTiles, testing::ValuesIn(kApis), apiTestName);

}  // namespace
}  // namespace pelage::test
