// A texture of an engine on strands: which color of it a strand takes, from which mip level, and
// that it costs nothing without one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pelage/random.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/lists.h"
#include "support/not_numbers.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

constexpr uint32_t kTexturePixels = 64, kTextureVertices = 4;
constexpr const char* kPass = "sample_strand_colors";

double toDouble(float x) { return static_cast<double>(x); }

struct Root {
  Float3 position;
  Float2 uv;
};

// Strands of 2 cm along z.
HairAsset groomOf(const std::vector<Root>& roots) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(roots.size());
  asset.verticesPerStrand = kTextureVertices;
  for (const Root& root : roots) {
    const Float3 p = root.position;
    asset.strandUv.push_back(root.uv);
    for (uint32_t v = 0; v < kTextureVertices; ++v) {
      const float along = 0.02f * static_cast<float>(v) / (kTextureVertices - 1);
      asset.positions.push_back({p.x, p.y, p.z + along, v < 2 ? 0.0f : 1.0f});
    }
  }
  expectOk(asset.process());
  return asset;
}

// Bars across the picture of bars(), from the lowest to the topmost.
HairAsset barsOf(const std::vector<Float2>& uvs) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(uvs.size());
  asset.verticesPerStrand = kTextureVertices;
  asset.strandUv = uvs;
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const float y = 0.02f * (static_cast<float>(s) - 0.5f * static_cast<float>(uvs.size() - 1));
    for (uint32_t v = 0; v < kTextureVertices; ++v)
      asset.positions.push_back({-0.1f + 0.2f * static_cast<float>(v) / (kTextureVertices - 1), y,
                                 0, v < 2 ? 0.0f : 1.0f});
  }
  expectOk(asset.process());
  return asset;
}

View viewFrom(float distance, uint32_t pixels = kTexturePixels) {
  return cameraView(
      {.eye = {0, 0, distance}, .fov = 0.4f, .width = pixels, .nearPlane = 0.01f, .farPlane = 100});
}

/// 1 m of the surface has 1 of the UV; random roots in a square of 20 cm.
std::vector<Root> scattered(uint32_t count) {
  pelage::Random random(11);
  std::vector<Root> roots(count);
  for (Root& root : roots) {
    root.position = {0.2f * random.uniform() - 0.1f, 0.2f * random.uniform() - 0.1f, 0};
    root.uv = {0.5f + root.position.x, 0.5f + root.position.y};
  }
  return roots;
}

class StrandTextureTest : public SceneRunTest<> {
 protected:
  void SetUp() override {
    SceneRunTest::SetUp();
    if (run_.device() != nullptr) messages_ = device().messageCount();
  }
  void TearDown() override {
    SceneRunTest::TearDown();
    if (run_.device() == nullptr) return;
    run_.scene.setTier(device().info().tier);
    EXPECT_EQ(device().messageCount(), messages_) << "the driver or a layer complained";
  }
  HeadlessDevice& device() { return *run_.device(); }

  HairObject& add(const HairAsset& asset, HairDef def) {
    def.strandUvs = true;
    HairObject& hair = run_.add(asset, def);
    hair.simulated = false;
    StrandMaterial& m = hair.material;
    m.rootColor = m.tipColor = {1, 1, 1};
    m.colorVariation = m.diffuseStrength = m.primaryStrength = m.secondaryStrength = 0;
    m.fiberRadius = 0.008f;
    m.tipRadiusRatio = 1;
    run_.step();
    return hair;
  }
  TextureId create(const TextureDef& def) {
    const Result<TextureId> texture = device().createTexture(def);
    EXPECT_TRUE(texture) << texture.error().message;
    return texture ? *texture : TextureId::kInvalid;
  }
  /// All of a mip level l has the red (l + 1) / 16.
  StrandTexture levels() {
    constexpr uint32_t kWidth = 512, kHeight = 256, kLevels = 10;
    std::vector<float> texels;
    for (uint32_t level = 0; level < kLevels; ++level) {
      const uint32_t count = std::max(kWidth >> level, 1u) * std::max(kHeight >> level, 1u);
      for (uint32_t i = 0; i < count; ++i)
        texels.insert(texels.end(), {static_cast<float>(level + 1) / 16, 0.5f, 0, 1});
    }
    return {create({.shape = TextureShape::kPlane,
                    .width = kWidth,
                    .height = kHeight,
                    .mipLevels = kLevels,
                    .texels = texels}),
            kWidth, kHeight, kLevels};
  }

  std::vector<PassList> write(const View& view, const TransparencySettings& settings = {}) {
    std::vector<PassList> lists;
    const Light light = {.color = {0, 0, 0}, .ambient = {1, 1, 1}};
    expectOk(run_.scene.draw(view, {&light, 1}, settings, lists));
    return lists;
  }
  Result<RenderedImage> render(std::vector<PassList>& lists, const View& view) {
    return run_.renderLists(lists, {.width = view.width, .height = view.height});
  }
  RenderedImage picture(const View& view, const TransparencySettings& settings = {}) {
    std::vector<PassList> lists = write(view, settings);
    return imageOf(render(lists, view), {.width = view.width, .height = view.height});
  }
  static size_t passesOf(const std::vector<PassList>& lists) {
    size_t count = 0;
    for (const PassList& list : lists) count += countPasses(list, kPass);
    return count;
  }
  /// [guide] red that the first pass of a list that has run found.
  std::vector<double> reds(const PassList& list) {
    for (const Pass& pass : list.passes) {
      if (std::string(pass.name) != kPass) continue;
      for (const PassBinding& b : list.bindingsOf(pass)) {
        if (std::string(pass.layouts()[b.set]->entries[b.entry].name) != "g_strandColors") continue;
        const auto raw = device().read(b.buffer, b.offset, b.size);
        EXPECT_TRUE(raw) << raw.error().message;
        std::vector<Uint2> words(b.size / sizeof(Uint2));
        if (raw) std::memcpy(words.data(), raw->data(), raw->size());
        std::vector<double> result;
        for (size_t i = 1; i < words.size(); i += 2)
          result.push_back((words[i].x & 0xffffu) / 65535.0);
        return result;
      }
    }
    ADD_FAILURE() << "no pass samples the texture";
    return {};
  }

 private:
  uint32_t messages_ = 0;
};
INSTANTIATE_TEST_SUITE_P(All, StrandTextureTest, testing::ValuesIn(kRuntimeApis), apiTestName);

// HairBuffers::strandUvs of a root, found by looking at all others.
Float4 surfaceAt(const std::vector<Root>& roots, size_t at) {
  const auto square = [](double x, double y, double z) { return x * x + y * y + z * z; };
  std::vector<std::pair<double, double>> others;  // squares of distances on the surface and in UV
  const Root& own = roots[at];
  for (size_t i = 0; i < roots.size(); ++i) {
    const Root& r = roots[i];
    if (i == at) continue;
    others.emplace_back(
        square(toDouble(r.position.x) - toDouble(own.position.x),
               toDouble(r.position.y) - toDouble(own.position.y),
               toDouble(r.position.z) - toDouble(own.position.z)),
        square(toDouble(r.uv.x) - toDouble(own.uv.x), toDouble(r.uv.y) - toDouble(own.uv.y), 0));
  }
  std::sort(others.begin(), others.end());
  others.resize(std::min<size_t>(others.size(), 4));
  std::vector<double> changes;
  for (const auto& [metres, uv] : others)
    if (metres > 0) changes.push_back(std::sqrt(uv / metres));
  std::sort(changes.begin(), changes.end());
  Float4 result = {own.uv.x, own.uv.y, 0, 0};
  if (!others.empty())
    result.z = static_cast<float>(
        std::sqrt(others.back().first * std::numbers::pi / static_cast<double>(others.size())));
  if (!changes.empty()) result.w = static_cast<float>(changes[(changes.size() - 1) / 2]);
  return result;
}

void expectSurfaces(SceneRun& run, const HairObject& hair, const std::vector<Root>& roots) {
  const std::vector<Float4> found = run.read(hair.buffers().strandUvs);
  ASSERT_EQ(found.size(), roots.size());
  double worst = 0;
  for (size_t i = 0; i < roots.size(); ++i) {
    const Float4 wanted = surfaceAt(roots, i);
    EXPECT_EQ(found[i].x, wanted.x);
    EXPECT_EQ(found[i].y, wanted.y);
    for (const auto& [a, b] : {std::pair(found[i].z, wanted.z), std::pair(found[i].w, wanted.w)})
      keepLargest(worst, std::abs(toDouble(a) - toDouble(b)) / std::max(toDouble(b), 1e-6));
  }
  EXPECT_LE(worst, 1e-6);
}

TEST_P(StrandTextureTest, HasTheUvOfRootsAndWhatTheyStandFor) {
  std::vector<Root> roots = scattered(500);
  expectSurfaces(run_, add(groomOf(roots), {}), roots);
  // Across a seam, at one point, and alone.
  for (Root& root : roots) root.uv.x -= root.position.x > 0 ? 0.5f : 0.0f;
  const HairObject& cut = add(groomOf(roots), {});
  expectSurfaces(run_, cut, roots);
  uint32_t torn = 0;
  for (const Float4& root : run_.read(cut.buffers().strandUvs)) torn += root.w > 1.01f ? 1 : 0;
  EXPECT_LE(torn, 15u) << "of 500 roots, those beside the seam";
  for (Root& root : roots) root.position = {0.01f, 0, 0};
  expectSurfaces(run_, add(groomOf(roots), {}), roots);
  roots.resize(1);
  expectSurfaces(run_, add(groomOf(roots), {}), roots);
}

// The level that docs/shading.md promises.
double levelOf(const Float4& root, const StrandTexture& texture, double spread, double pixel) {
  const double footprint = std::max(toDouble(root.z) * spread, pixel) * toDouble(root.w);
  const double level = std::log2(footprint * std::max(texture.width, texture.height));
  return std::clamp(level + toDouble(texture.lodBias), 0.0, texture.mipLevels - 1.0);
}

TEST_P(StrandTextureTest, TakesTheLevelOfRootsOrPixels) {
  const std::vector<Root> roots = scattered(1200);
  HairObject& hair = add(groomOf(roots), {});
  const StrandTexture texture = levels();
  std::vector<Float4> surfaces;
  for (size_t i = 0; i < roots.size(); ++i) surfaces.push_back(surfaceAt(roots, i));
  double worst = 0, finest = 100, coarsest = 0;
  for (const float distance : {0.5f, 4.0f, 30.0f}) {
    for (const float share : {1.0f, 0.25f}) {
      for (const float bias : {0.0f, -1.5f, 3.0f}) {
        hair.strandTexture = texture;
        hair.strandTexture.lodBias = bias;
        hair.drawnShare = share;
        const View view = viewFrom(distance);
        std::vector<PassList> lists = write(view);
        ASSERT_TRUE(render(lists, view));
        const std::vector<double> found = reds(lists[0]);
        ASSERT_EQ(found.size(), roots.size());
        // The eye looks along -z at roots in the plane z = 0.
        const double pixel = toDouble(distance) * 2 * std::tan(0.2) / kTexturePixels;
        const double spread = std::sqrt(1 / toDouble(share));
        for (size_t i = 0; i < roots.size(); ++i) {
          const double level = levelOf(surfaces[i], hair.strandTexture, spread, pixel);
          keepLargest(worst, std::abs(found[i] * 16 - 1 - level));
          keepSmallest(finest, level);
          keepLargest(coarsest, level);
        }
      }
    }
  }
  std::cout << "off by " << worst << " levels\n";
  // Samplers interpolate between levels in steps of 1/256.
  EXPECT_LE(worst, 0.01);
  EXPECT_EQ(finest, 0);
  EXPECT_EQ(coarsest, texture.mipLevels - 1.0);
}

// Rows of a picture through the middle of each bar.
std::vector<Float4> barsIn(const RenderedImage& image, uint32_t count) {
  std::vector<Float4> colors;
  const double half = 0.6 * std::tan(0.2);
  for (uint32_t i = 0; i < count; ++i) {
    const double y = 0.02 * (i - 0.5 * (count - 1));
    const auto row = static_cast<uint32_t>((0.5 - 0.5 * y / half) * kTexturePixels);
    colors.push_back(image.pixels[size_t{row} * kTexturePixels + kTexturePixels / 2]);
  }
  return colors;
}

constexpr Float4 kTexels[] = {{1, 0, 0, 1},        {0, 1, 0, 1},       {0, 0, 1, 1},
                              {0.25f, 0.5f, 1, 1}, {0.5f, 0.5f, 0, 1}, {0.125f, 0, 0.75f, 1}};
// The middles of these texels of 3 x 2; the last three repeat.
const std::vector<Float2> kUvs = {{1.0f / 6, 0.25f}, {0.5f, 0.25f},   {5.0f / 6, 0.25f},
                                  {7.0f / 6, 0.75f}, {-0.5f, -1.25f}, {5.0f / 6, 2.75f}};

TextureDef planeOf(std::span<const Float4> texels, std::vector<float>& values) {
  values.clear();
  for (const Float4& t : texels) values.insert(values.end(), {t.x, t.y, t.z, t.w});
  return {.shape = TextureShape::kPlane, .width = 3, .height = 2, .texels = values};
}

TEST_P(StrandTextureTest, ColorsStrandsAtTheirRootsInEveryMethod) {
  // Pelage's own texture, which it takes the place of, is black.
  const std::vector<Float4> black(4, {0, 0, 0, 1});
  HairObject& hair = add(barsOf(kUvs), {.baseTexture = {2, 2, black}});
  std::vector<float> values;
  const TextureId texture = create(planeOf(kTexels, values));
  hair.strandTexture = {texture, 3, 2};
  const View view = viewFrom(0.6f);
  for (const Tier tier : {device().info().tier, Tier::kEs}) {
    run_.scene.setTier(tier);
    for (const Transparency method :
         {Transparency::kAlphaTest, Transparency::kStochastic, Transparency::kWindowed,
          Transparency::kHybrid4, Transparency::kShortCut, Transparency::kTiles}) {
      const std::vector<Float4> found =
          barsIn(picture(view, {.method = method, .nodeCount = 1 << 15}), 6);
      double worst = 0;
      for (size_t i = 0; i < found.size(); ++i) {
        keepLargest(worst, std::abs(toDouble(found[i].x) - toDouble(kTexels[i].x)));
        keepLargest(worst, std::abs(toDouble(found[i].y) - toDouble(kTexels[i].y)));
        keepLargest(worst, std::abs(toDouble(found[i].z) - toDouble(kTexels[i].z)));
      }
      // Layers have seven bits of a channel.
      EXPECT_LE(worst, 1.0 / 100) << static_cast<int>(method);
    }
  }
  // Without it, the object's own is there again.
  hair.strandTexture = {};
  for (const Float4& color : barsIn(picture(view), 6)) EXPECT_LE(color.x + color.y + color.z, 0);
}

TEST_P(StrandTextureTest, AlphaMultipliesOpacityAndFollowHairsTakeTheirGuides) {
  const std::vector<FollowHair> follows = {{.guide = 1, .offset = {0, 0.02f, 0, 1}}};
  HairDef def;
  def.followHairs = follows;
  HairObject& hair = add(barsOf({{1.0f / 6, 0.25f}, {0.5f, 0.25f}}), def);
  const std::vector<Float4> texels = {{1, 0, 0, 1}, {0, 1, 0, 0.25f}, {0, 0, 0, 0},
                                      {0, 0, 0, 0}, {0, 0, 0, 0},     {0, 0, 0, 0}};
  std::vector<float> values;
  hair.strandTexture = {create(planeOf(texels, values)), 3, 2};
  const View view = viewFrom(0.6f);
  for (const Tier tier : {device().info().tier, Tier::kEs}) {
    run_.scene.setTier(tier);
    const RenderedImage image = picture(view, {.nodeCount = 1 << 15});
    const auto at = [&](double y) {
      const auto row =
          static_cast<uint32_t>((0.5 - 0.5 * y / (0.6 * std::tan(0.2))) * kTexturePixels);
      return image.pixels[size_t{row} * kTexturePixels + kTexturePixels / 2];
    };
    for (const auto& [y, wanted] :
         {std::pair(-0.01, Float4{1, 0, 0, 1}), std::pair(0.01, Float4{0, 0.25f, 0, 0.25f}),
          std::pair(0.03, Float4{0, 0.25f, 0, 0.25f})}) {
      const Float4 found = at(y);
      EXPECT_NEAR(found.x, wanted.x, 0.004f) << y;
      EXPECT_NEAR(found.y, wanted.y, 0.004f) << y;
      EXPECT_NEAR(found.w, wanted.w, 0.004f) << y;
    }
    // Only the first strand is opaque enough for depth.
    PassList list;
    expectOk(run_.scene.drawDepth(view, {.opacity = 0.5f, .color = HairDepthColor::kDepth}, list));
    std::vector<PassList> lists;
    lists.push_back(std::move(list));
    EXPECT_EQ(passesOf(lists), 1u);
    const Result<RenderedImage> depth = required(render(lists, view));
    uint32_t low = 0, high = 0;
    for (uint32_t y = 0; y < kTexturePixels; ++y)
      (y < kTexturePixels / 2 ? high : low) +=
          depth->pixels[size_t{y} * kTexturePixels + kTexturePixels / 2] != Float4{} ? 1 : 0;
    EXPECT_GT(low, 0u);
    EXPECT_EQ(high, 0u);
  }
}

TEST_P(StrandTextureTest, ViewsOfAFrameHaveColorsOfTheirOwn) {
  HairObject& hair = add(groomOf(scattered(200)), {});
  hair.strandTexture = levels();
  const View views[] = {viewFrom(0.5f), viewFrom(30)};
  std::vector<PassList> lists[2];
  for (int i : {0, 1}) lists[i] = write(views[i]);
  for (int i : {0, 1}) ASSERT_TRUE(render(lists[i], views[i]));
  const std::vector<double> near = reds(lists[0][0]), far = reds(lists[1][0]);
  ASSERT_EQ(near.size(), far.size());
  for (size_t i = 0; i < near.size(); ++i) EXPECT_GT(far[i], near[i] + 1.0 / 16);
  // The next frame has their buffers again.
  run_.step();
  const uint32_t buffers = run_.scene.resources().count();
  for (int i : {0, 1}) lists[i] = write(views[i]);
  EXPECT_EQ(run_.scene.resources().count(), buffers);
}

TEST_P(StrandTextureTest, CostsNothingWithoutOne) {
  const HairAsset asset = barsOf(kUvs);
  const View view = viewFrom(0.6f);
  // The same look without the UV.
  HairObject& hair = add(asset, {});
  const RenderedImage with = picture(view);
  const uint32_t buffers = run_.scene.resources().count();
  const std::vector<PassList> lists = write(view);
  EXPECT_EQ(passesOf(lists), 0u);
  EXPECT_EQ(run_.scene.resources().count(), buffers);
  const StrandMaterial material = hair.material;
  run_.clear();
  HairObject& bare = run_.add(asset);
  EXPECT_EQ(bare.buffers().strandUvs, BufferId::kInvalid);
  bare.simulated = false;
  bare.material = material;
  run_.step();
  const RenderedImage without = picture(view);
  EXPECT_TRUE(with.pixels == without.pixels);
  for (const PassList& list : write(view))
    for (const PassBinding& binding : list.bindings)
      EXPECT_EQ(binding.texture, TextureId::kInvalid);
}

TEST_P(StrandTextureTest, OfWhichTheRuntimeDoesNotKnowIsRefused) {
  HairObject& hair = add(barsOf(kUvs), {});
  hair.strandTexture = {newTextureId(), 4, 4};
  const View view = viewFrom(0.6f);
  std::vector<PassList> lists = write(view);
  expectError(render(lists, view), "g_strandTexture");
}

TEST(StrandTextureErrors, NameWhatIsWrong) {
  Scene scene;
  HairAsset asset = barsOf(kUvs);
  const auto hair = scene.addHair(asset, {.name = "bars", .strandUvs = true});
  const auto bare = scene.addHair(asset, {.name = "bare"});
  ASSERT_TRUE(hair && bare);
  const TextureId id = newTextureId();
  const auto refused = [&](HairId object, const StrandTexture& texture, const char* word) {
    scene.hair(object).strandTexture = texture;
    PassList list;
    const Result<void> drawn = scene.draw(viewFrom(0.6f), {}, list);
    const Result<void> depth = scene.drawDepth(viewFrom(0.6f), {}, list);
    scene.hair(object).strandTexture = {};
    for (const Result<void>& result : {drawn, depth}) {
      expectError(result, {word});
    }
    EXPECT_TRUE(list.passes.empty());
  };
  refused(*bare, {id, 4, 4}, "HairDef::strandUvs");
  refused(*hair, {id, 0, 4}, "0 x 4 texels");
  refused(*hair, {id, 4, 65537}, "4 x 65537 texels");
  refused(*hair, {id, 4, 4, 0}, "mipLevels is 0");
  refused(*hair, {id, 4, 4, 18}, "mipLevels is 18");
  refused(*hair, {id, 4, 4, 1, kNan}, "lodBias");
  refused(*hair, {id, 4, 4, 1, 16.5f}, "lodBias");
  PassList list;
  expectOk(scene.draw(viewFrom(0.6f), {}, list));
  asset.strandUv.clear();
  expectError(scene.addHair(asset, {.name = "plain", .strandUvs = true}), "strandUv");
}

}  // namespace
}  // namespace pelage::test
