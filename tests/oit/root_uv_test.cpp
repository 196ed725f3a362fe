// The UV of roots in an engine's lights: by every method, without a texture, with pelage's own and
// with an engine's; and what lights without ROOT_UV take.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "oit/tangle.h"
#include "pelage/engine_lights.h"
#include "support/extremes.h"
#include "test_lights/kernels.h"
#include "uv_lights/kernels.h"

namespace pelage::test {
namespace {

constexpr uint32_t kBarPixels = 48, kBarVertices = 4, kBars = 5;
// The last two repeat.
const std::vector<Float2> kBarUvs = {
    {0.125f, 0.75f}, {0.9f, 0.1f}, {0, 0.5f}, {1.25f, -0.25f}, {-3.5f, 7.625f}};

// Bars across the picture; the last one is a follow hair of the one below it.
HairAsset bars() {
  HairAsset asset;
  asset.strandCount = kBars;
  asset.verticesPerStrand = kBarVertices;
  asset.strandUv = kBarUvs;
  for (uint32_t s = 0; s < kBars; ++s)
    for (uint32_t v = 0; v < kBarVertices; ++v)
      asset.positions.push_back({-0.1f + 0.2f * static_cast<float>(v) / (kBarVertices - 1),
                                 0.02f * (static_cast<float>(s) - 2.5f), 0, v < 2 ? 0.0f : 1.0f});
  expectOk(asset.process());
  return asset;
}

class RootUvTest : public SceneRunTest<> {
 protected:
  void TearDown() override {
    SceneRunTest::TearDown();
    if (run_.device() != nullptr) run_.scene.setTier(run_.device()->info().tier);
  }
  HairObject& add(HairDef def) {
    const FollowHair follow = {.guide = kBars - 1, .offset = {0, 0.02f, 0, 1}};
    def.followHairs = {&follow, 1};
    HairObject& hair = run_.add(bars(), def);
    hair.simulated = false;
    hair.material.fiberRadius = 0.008f;
    hair.material.tipRadiusRatio = 1;
    run_.step();
    return hair;
  }
  static View view() {
    return cameraView({.eye = {0, 0, 0.6f},
                       .fov = 0.4f,
                       .width = kBarPixels,
                       .nearPlane = 0.01f,
                       .farPlane = 100});
  }
  static TransparencySettings settingsOf(Transparency method, const EngineLights& lights) {
    return {.method = method, .nodeCount = 1 << 14, .engineLights = &lights};
  }
  /// Colors of each bar, and of the follow hair behind them.
  std::vector<Float4> colorsOf(const TransparencySettings& settings) {
    std::vector<PassList> lists;
    expectOk(run_.scene.draw(view(), {}, settings, lists));
    const auto image = run_.renderLists(lists, {.width = kBarPixels, .height = kBarPixels});
    EXPECT_TRUE(image) << image.error().message;
    std::vector<Float4> colors;
    for (uint32_t bar = 0; bar <= kBars && image; ++bar) {
      const double y = 0.02 * (bar - 2.5) / (0.6 * std::tan(0.2));
      const auto row = static_cast<uint32_t>((0.5 - 0.5 * y) * kBarPixels);
      colors.push_back(image->pixels[size_t{row} * kBarPixels + kBarPixels / 2]);
    }
    return colors;
  }
  void expectUvs(const char* what) {
    const EngineLights lights{.kernels = uv_lights::allKernels()};
    for (const Tier tier : {run_.device()->info().tier, Tier::kEs}) {
      run_.scene.setTier(tier);
      for (const Transparency method : kEachTransparency) {
        const std::vector<Float4> colors = colorsOf(settingsOf(method, lights));
        ASSERT_EQ(colors.size(), kBars + 1);
        double worst = 0;
        for (size_t i = 0; i < colors.size(); ++i) {
          const Float2 uv = kBarUvs[i < kBars ? i : kBars - 1];
          const float wanted[] = {uv.x - std::floor(uv.x), uv.y - std::floor(uv.y), 0.5f};
          const float found[] = {colors[i].x, colors[i].y, colors[i].z};
          for (int c = 0; c < 3; ++c)
            keepLargest(worst,
                        std::abs(static_cast<double>(found[c]) - static_cast<double>(wanted[c])));
        }
        // Layers have seven bits of a channel.
        EXPECT_LE(worst, 1.0 / 127) << what << ", method " << static_cast<int>(method);
      }
    }
  }
};
INSTANTIATE_TEST_SUITE_P(All, RootUvTest, testing::ValuesIn(kApis), apiTestName);

TEST_P(RootUvTest, IsInLightsWithAndWithoutATexture) {
  const std::vector<Float4> texels(6, {0.5f, 0.5f, 0.5f, 1});
  add({.strandUvs = true});
  expectUvs("no texture");
  run_.clear();
  add({.baseTexture = {3, 2, texels}, .strandUvs = true});
  expectUvs("pelage's texture");
  run_.clear();
  const std::vector<float> values(24, 1.0f);
  const Result<TextureId> texture = required(run_.device()->createTexture(
      {.shape = TextureShape::kPlane, .width = 3, .height = 2, .texels = values}));
  add({.strandUvs = true}).strandTexture = {*texture, 3, 2};
  expectUvs("an engine's texture");
}

TEST_P(RootUvTest, IsZeroWhereTheObjectHasNone) {
  add({});
  const EngineLights lights{.kernels = uv_lights::allKernels()};
  for (const Tier tier : {run_.device()->info().tier, Tier::kEs}) {
    run_.scene.setTier(tier);
    for (const Transparency method : kEachTransparency)
      for (const Float4& color : colorsOf(settingsOf(method, lights))) {
        EXPECT_LE(std::abs(color.x) + std::abs(color.y), 0) << static_cast<int>(method);
        EXPECT_GT(color.z, 0.48f) << static_cast<int>(method);
      }
  }
}

// Lights that do not read it have the lists, nodes and kernels that they had.
TEST(RootUvCost, IsFourBytesANodeOfLightsThatReadIt) {
  const EngineLights with{.kernels = uv_lights::allKernels()};
  const EngineLights without{.kernels = test_lights::allKernels()};
  TransparencySettings settings = {.method = Transparency::kWindowed, .nodeCount = 1000};
  const auto planOf = [&](const EngineLights* lights) {
    settings.engineLights = lights;
    return valueOf(planTransparency(32, 32, settings));
  };
  EXPECT_EQ(planOf(&without).bytes, planOf(nullptr).bytes);
  EXPECT_EQ(planOf(&with).bytes, planOf(nullptr).bytes + 4000);
  settings.nodeCount = 7;
  EXPECT_EQ(planOf(&without).nodeCount, 7u);
  EXPECT_EQ(planOf(&with).nodeCount, 4u);
  settings.nodeCount = 1;
  EXPECT_EQ(planOf(&with).nodeCount, 4u);
  size_t read = 0, drawn = 0;
  for (const Kernel* kernel : uv_lights::allKernels()) read += kernel->variants.size();
  for (const Kernel* kernel : test_lights::allKernels()) drawn += kernel->variants.size();
  EXPECT_EQ(drawn, 14u);
  EXPECT_EQ(read, 16u);
}

}  // namespace
}  // namespace pelage::test
