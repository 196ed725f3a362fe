// Transparency::kTiles: the picture of the exact composite without rasteriser and lists.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "oit/tangle.h"
#include "support/extremes.h"

namespace pelage::test {
namespace {

constexpr uint32_t kPixels = 48;

TransparencySettings lists() {
  TransparencySettings settings;
  settings.nodeCount = 1 << 18;
  return settings;
}

TransparencySettings tiles() {
  TransparencySettings settings;
  settings.method = Transparency::kTiles;
  return settings;
}

/// Largest difference of a channel.
double worstDifference(const RenderedImage& a, const RenderedImage& b) {
  if (a.pixels.size() != b.pixels.size()) return 1e9;
  double worst = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const Float4 p = a.pixels[i], q = b.pixels[i];
    for (const float difference : {p.x - q.x, p.y - q.y, p.z - q.z, p.w - q.w})
      keepLargest(worst, std::abs(static_cast<double>(difference)));
  }
  return worst;
}

double covered(const RenderedImage& image) {
  double sum = 0;
  for (const Float4& p : image.pixels) sum += static_cast<double>(p.w);
  return sum / static_cast<double>(image.pixels.size());
}

class StrandTiles : public TangleTest {
 protected:
  /// Both methods draw the same.
  void expectSame(TangleRun& scene, const View& view, const std::string& what,
                  double leastCovered) {
    const RenderedImage exact = scene.render(view, lists());
    const RenderedImage image = scene.render(view, tiles());
    EXPECT_TRUE(allFinite(image)) << what;
    EXPECT_GT(covered(exact), leastCovered) << what;
    const double worst = worstDifference(exact, image);
    EXPECT_LE(worst, 1.0 / 255) << what;
    std::cout << apiName(GetParam()) << " " << what << ": worst " << 255 * worst << "/255\n";
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
    expectSame(tangleRun(), tangleView(kPixels, c.reversed), "radius " + std::to_string(c.radius),
               c.covered);
  }
}

TEST_P(StrandTiles, AreThePictureOfTheListsAtAndBehindTheEye) {
  tangleRun().add({.strands = 300});
  View view = tangleView(kPixels);
  // In the middle of the hair: strands behind the eye, through the near plane and across it.
  view.eye = {0, 0, 0};
  for (const bool reversedDepth : {false, true}) {
    view.worldToClip =
        lookAt(view.eye, {0, 0, -1}, {0, 1, 0}, 1.5f, 1, 0.001f, 1.0f, reversedDepth);
    view.reversedDepth = reversedDepth;
    expectSame(tangleRun(), view, reversedDepth ? "eye reversed" : "eye", 0.1);
  }
  // Long segments, many of them from before the eye to behind it.
  TangleRun scene(GetParam());
  HairAsset needles;
  needles.strandCount = 90;
  needles.verticesPerStrand = 2;
  Random random(9);
  const auto within = [&](float range) { return range * (2 * random.uniform() - 1); };
  for (uint32_t i = 0; i < needles.strandCount; ++i) {
    needles.positions.push_back({within(0.1f), within(0.1f), -0.02f - 0.2f * random.uniform(), 0});
    needles.positions.push_back({within(0.2f), within(0.2f), within(0.3f), 1});
  }
  expectOk(needles.process());
  HairDef def;
  def.material = tangleMaterial({.opacity = 0.5f});
  def.settings.gravity = {0, 0, 0};
  scene.run.add(needles, def);
  scene.run.step();
  for (const bool reversedDepth : {false, true}) {
    view.worldToClip = lookAt(view.eye, {0, 0, -1}, {0, 1, 0}, 1.5f, 1, 0.02f, 1.0f, reversedDepth);
    view.reversedDepth = reversedDepth;
    expectSame(scene, view, reversedDepth ? "needles reversed" : "needles", 0.1);
  }
  // Planes that cut many strands, near and far.
  view = tangleView(kPixels);
  view.worldToClip = lookAt(view.eye, {0, 0, 0}, {0, 1, 0}, 0.5f, 1, 0.48f, 0.53f);
  expectSame(tangleRun(), view, "planes", 0.03);
}

TEST_P(StrandTiles, AreThePictureOfTheListsForEverySizeOfTheView) {
  tangleRun().add({.strands = 300});
  for (const uint32_t size : {1u, 9u, 37u}) {
    View view = tangleView(kPixels);
    view.width = size;
    view.height = size + size / 2;
    expectSame(tangleRun(), view, std::to_string(size) + " pixels", 0.01);
  }
}

TEST_P(StrandTiles, DrawAllKindsOfHairObjects) {
  HairAsset asset = tangle({.strands = 60});
  Random random(5);
  for (uint32_t i = 0; i < asset.strandCount; ++i)
    asset.strandUv.push_back({random.uniform(), random.uniform()});
  for (uint32_t i = 0; i < asset.strandCount; ++i)
    asset.strandThickness.push_back(0.5f + random.uniform());
  for (size_t i = 0; i < asset.positions.size(); ++i)
    asset.vertexColor.push_back(
        {1, random.uniform(), random.uniform(), 0.5f + 0.5f * random.uniform()});
  const std::vector<Float4> texels = {
      {1, 0.2f, 0.1f, 1}, {0.3f, 1, 0.2f, 0.8f}, {0.2f, 0.3f, 1, 0.5f}, {1, 1, 0.5f, 1}};
  HairDef def;
  def.material = tangleMaterial({.opacity = 0.5f});
  def.settings.gravity = {0, 0, 0};
  const Result<std::vector<FollowHair>> follow =
      asset.generateFollowHairs({.countPerGuide = 6, .maxRadius = 0.01f});
  ASSERT_TRUE(follow) << follow.error().message;
  def.followHairs = *follow;
  def.baseTexture = {2, 2, texels};
  HairObject& first = tangleRun().run.add(asset, def);
  first.drawnShare = 0.7f;
  tangleRun().add({.strands = 200, .seed = 11});
  tangleRun().hair().material.model = ShadingModel::kFiber;
  expectSame(tangleRun(), tangleView(kPixels), "two objects", 0.2);
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
    View view = tangleView(kPixels - 5, reversedDepth);
    RenderTargetDef target;
    target.width = view.width;
    target.height = view.height;
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
      TransparencySettings solid;
      solid.method = Transparency::kStochastic;
      Scene& scene = tangleRun().run.scene;
      opaque.visible = true;
      tangleRun().hair().visible = false;
      expectOk(scene.draw(view, tangleLights(), solid, drawn));
      opaque.visible = false;
      tangleRun().hair().visible = true;
      expectOk(scene.draw(view, tangleLights(), settings, drawn));
      std::vector<const PassList*> pointers;
      for (PassList& list : drawn) {
        scene.finish(list);
        pointers.push_back(&list);
      }
      expectOk(tangleRun().run.device()->update(scene.resources()));
      Result<RenderedImage> image = tangleRun().run.device()->render(pointers, target, nullptr);
      EXPECT_TRUE(image) << image.error().message;
      return image ? *image : RenderedImage{};
    };
    const RenderedImage exact = render(lists());
    TransparencySettings settings = tiles();
    const RenderedImage before = render(settings);
    settings.opaqueDepth = target.depthCopy;
    const RenderedImage image = render(settings);
    EXPECT_GT(worstDifference(exact, before), 0.1) << "some hair is behind the bars";
    EXPECT_LE(worstDifference(exact, image), 1.0 / 255);

    settings.opaqueDepth = tangleRun().resources().add({.name = "small", .size = 64, .stride = 4});
    std::vector<PassList> none;
    const Result<void> refused = tangleRun().run.scene.draw(view, tangleLights(), settings, none);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("opaqueDepth has 64 bytes"), std::string::npos);
  }
}

TEST_P(StrandTiles, DoNotDependOnTheOrderOfStrands) {  // K36
  const View view = tangleView(kPixels);
  tangleRun().add({.strands = 300});
  const RenderedImage image = tangleRun().render(view, tiles());
  TangleRun other(GetParam());
  other.add({.strands = 300, .reversed = true});
  EXPECT_TRUE(sameBits(image, other.render(view, tiles())));
  // The next frame finds tiles that were used before.
  EXPECT_TRUE(sameBits(image, tangleRun().render(view, tiles())));
}

TEST_P(StrandTiles, DoNotDependOnTheOrderOfStrandsAtOnePlace) {  // K36
  const TangleDef def = {.strands = 20, .radius = 0.005f, .opacity = 0.6f};
  tangleRun().add(def, twins(tangle(def), false));
  const RenderedImage image = tangleRun().render(tangleView(kPixels), tiles());
  TangleRun other(GetParam());
  other.add(def, twins(tangle(def), true));
  EXPECT_GT(covered(image), 0.1);
  EXPECT_TRUE(sameBits(image, other.render(tangleView(kPixels), tiles())));
}

TEST_P(StrandTiles, StandAlphasOfZeroAndOneAndHundredsOfLayers) {
  tangleRun().add({.strands = 100, .opacity = 0});
  for (const Float4& p : tangleRun().render(tangleView(kPixels), tiles()).pixels)
    EXPECT_EQ(p, Float4{});
  // They fill whole tiles.
  HairAsset stack;
  stack.strandCount = 240;
  stack.verticesPerStrand = 2;
  Random random(3);
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
    HairDef hairDef;
    hairDef.material = tangleMaterial({.opacity = opacity});
    hairDef.material.fiberRadius = 0.3f;
    hairDef.material.tipRadiusRatio = 1;
    hairDef.settings.gravity = {0, 0, 0};
    scene.run.add(stack, hairDef);
    scene.run.step();
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
  const View view = tangleView(kPixels);
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
  EXPECT_GT(empty, kPixels * kPixels / 4);
  EXPECT_GT(same, kPixels * kPixels / 4);
  EXPECT_TRUE(sameBits(half, tangleRun().render(view, settings)));

  settings.nodeCount = 1;
  for (const Float4& p : tangleRun().render(view, settings).pixels) EXPECT_EQ(p, Float4{});
  const TransparencyCounters one = tangleRun().counters(1);
  EXPECT_EQ(one.spilled, all.fragments - 1);
  settings.nodeCount = growNodes(one, 1);
  EXPECT_TRUE(sameBits(whole, tangleRun().render(view, settings)));
}

TEST_P(StrandTiles, StandPositionsAndTangentsThatAreNotNumbers) {
  tangleRun().add({.strands = 100});
  const View view = tangleView(kPixels);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float far = std::numeric_limits<float>::infinity();
  std::vector<Float4> positions = tangleRun().run.positions(tangleRun().hair());
  std::vector<Float4> tangents(positions.size(), {nan, 0, far, 0});
  for (size_t i = 0; i < positions.size(); i += 5) positions[i] = {nan, far, -far, nan};
  for (size_t i = 0; i < 6; ++i) positions[i] = {nan, nan, nan, nan};  // a whole strand
  const auto render = [&](const TransparencySettings& settings) {
    tangleRun().lists.assign(1, {});
    addUpload(tangleRun().lists[0], tangleRun().hair().buffers().positions,
              std::as_bytes(std::span(positions)));
    addUpload(tangleRun().lists[0], tangleRun().hair().buffers().tangents,
              std::as_bytes(std::span(tangents)));
    expectOk(tangleRun().run.scene.draw(view, tangleLights(), settings, tangleRun().lists));
    return tangleRun().renderLists(view).value_or(RenderedImage{});
  };
  const RenderedImage exact = render(lists());
  const RenderedImage image = render(tiles());
  EXPECT_TRUE(allFinite(image));
  EXPECT_GT(covered(exact), 0.01) << "the finite vertices are drawn";
  EXPECT_LE(worstDifference(exact, image), 1.0 / 255);

  // So far away that places on the screen and their products have no floats.
  for (size_t i = 6; i < positions.size(); i += 4) positions[i] = {1e17f, -3e17f, 2e17f, 0};
  EXPECT_TRUE(allFinite(render(tiles())));
}

TEST_P(StrandTiles, SayWhichCapIsTooSmall) {
  tangleRun().add({.strands = 20});
  const auto draw = [&](const TransparencySettings& settings) {
    std::vector<PassList> drawn;
    const Result<void> done =
        tangleRun().run.scene.draw(tangleView(kPixels), tangleLights(), settings, drawn);
    return done ? std::string() : done.error().message;
  };
  TransparencySettings settings = tiles();
  settings.maxBytes = 1000;
  EXPECT_NE(draw(settings).find("maxBytes is 1000"), std::string::npos);
  settings = tiles();
  settings.maxBufferBytes = 1000;
  EXPECT_NE(draw(settings).find("maxBufferBytes is 1000"), std::string::npos);

  const auto plan = planTransparency(kPixels, kPixels, tiles(), 20 * 6);
  ASSERT_TRUE(plan);
  settings = tiles();
  settings.maxBytes = plan->bytes;
  EXPECT_EQ(draw(settings), "");
  settings.maxBytes = plan->bytes - 400;
  const auto less = planTransparency(kPixels, kPixels, settings, 20 * 6);
  ASSERT_TRUE(less);
  EXPECT_EQ(less->nodeCount, plan->nodeCount - 100);
}

INSTANTIATE_TEST_SUITE_P(All, StrandTiles, testing::ValuesIn(kApis),
                         [](const auto& api) { return std::string(apiName(api.param)); });

}  // namespace
}  // namespace pelage::test
