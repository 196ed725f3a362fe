// Devices whose vertex stage has no storage buffers: strands are placed on the screen first, and
// draws take the records. The picture is that of strand_vertex.
#include <gtest/gtest.h>

#include <cmath>

#include "oit/tangle.h"
#include "support/errors.h"

namespace pelage::test {
namespace {

constexpr uint32_t kRecordPixels = 64;

constexpr Transparency kRecordMethods[] = {Transparency::kAlphaTest, Transparency::kStochastic,
                                           Transparency::kWindowed,  Transparency::kHybrid8,
                                           Transparency::kShortCut,  Transparency::kTiles};

// An object with all that draws read: factors, colors, a texture, and follow hairs that are
// computed from their guides.
HairDef fullDef(HairAsset& asset, const std::vector<Float4>& texels,
                const std::vector<FollowHair>& follows) {
  pelage::Random random(3);
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    asset.strandThickness.push_back(0.5f + random.uniform());
    asset.strandUv.push_back({4 * random.uniform() - 2, random.uniform()});
  }
  for (size_t i = 0; i < asset.positions.size(); ++i)
    asset.vertexColor.push_back({random.uniform(), random.uniform(), random.uniform(), 1});
  expectOk(asset.process());
  HairDef def = tangleHair({});
  def.baseTexture = {4, 2, texels};
  def.followHairs = follows;
  return def;
}

class TransformedStrands : public TangleTest {
 protected:
  /// The same picture with storage buffers in the vertex stage and without.
  void expectSame(TangleRun& scene, const View& view, const TransparencySettings& settings,
                  const std::string& what, double worstMean = 1e-4) {
    scene.run.scene.setTier(Tier::kWide);
    const RenderedImage wide = scene.render(view, settings);
    scene.run.scene.setTier(Tier::kBase);
    const RenderedImage base = scene.render(view, settings);
    ASSERT_TRUE(allFinite(base) && allFinite(wide)) << what;
    ASSERT_EQ(wide.pixels.size(), base.pixels.size());
    for (const PassList& list : scene.lists) {
      for (const Pass& pass : list.passes) {
        uint32_t buffers = 0;
        for (const PassBinding& binding : list.bindingsOf(pass)) {
          const LayoutEntry& entry = pass.layouts()[binding.set]->entries[binding.entry];
          const bool vertex = (binding.stages & stageBit(Stage::kVertex)) != 0;
          buffers += vertex && entry.kind == ResourceKind::kStorageBuffer ? 1 : 0;
        }
        EXPECT_EQ(buffers, 0u) << what << ": " << pass.name;
      }
    }
    double covered = 0, sum = 0;
    for (size_t i = 0; i < wide.pixels.size(); ++i) {
      const Float4 p = wide.pixels[i], q = base.pixels[i];
      covered += static_cast<double>(p.w) + static_cast<double>(p.x + p.y + p.z);
      for (const float difference : {p.x - q.x, p.y - q.y, p.z - q.z, p.w - q.w})
        sum += std::abs(static_cast<double>(difference));
    }
    const double mean = sum / static_cast<double>(4 * wide.pixels.size());
    EXPECT_GT(covered, 0.05 * static_cast<double>(wide.pixels.size())) << what;
    EXPECT_LE(mean, worstMean) << what;
    std::cout << apiName(GetParam()) << " " << what << ": mean difference " << 255 * mean
              << "/255\n";
  }
};

TEST_P(TransformedStrands, DrawThePictureOfStrandsFromStorageBuffers) {
  HairAsset asset = tangle({.strands = 150});
  const std::vector<Float4> texels = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 1, 1},
                                      {1, 1, 0, 1}, {0, 1, 1, 1}, {1, 0, 1, 1}, {.5f, .5f, .5f, 1}};
  std::vector<FollowHair> follows;
  for (uint32_t i = 0; i < 100; ++i)
    follows.push_back({.guide = i % asset.strandCount, .offset = {0.004f, 0.002f, 0, 1}});
  const HairDef def = fullDef(asset, texels, follows);
  TangleRun& scene = tangleRun();
  HairObject& hair = scene.run.add(asset, def);
  scene.add({.strands = 200, .vertices = 3});
  scene.run.step();
  for (const Transparency method : kRecordMethods) {
    TransparencySettings settings = {.method = method, .nodeCount = 1 << 17};
    const std::string name = "method " + std::to_string(static_cast<int>(method));
    expectSame(scene, tangleView(kRecordPixels), settings, name);
    expectSame(scene, tangleView(kRecordPixels, true), settings, name + " reversed");
  }
  // Some strands fade, the rest is wider; few of the follow hairs are left.
  hair.drawnShare = 0.4f;
  hair.material.fiberRadius = 0.006f;
  expectSame(scene, tangleView(kRecordPixels), {}, "share");
}

TEST_P(TransformedStrands, DrawWhatIsAtAndBehindTheEye) {
  tangleRun().add({.strands = 300});
  expectSame(tangleRun(), viewFromInside(kRecordPixels, false), {}, "eye");
}

TEST_P(TransformedStrands, CountAgainstTheMemoryOfTheView) {
  tangleRun().add({.strands = 300, .vertices = 6});
  Scene& scene = tangleRun().run.scene;
  std::vector<PassList> lists;
  TransparencySettings settings = {.method = Transparency::kStochastic,
                                   .maxBytes = 300 * 6 * 48 - 1};
  EXPECT_TRUE(scene.draw(tangleView(kRecordPixels), tangleLights(), settings, lists));
  scene.setTier(Tier::kEs);
  lists.clear();
  expectError(scene.draw(tangleView(kRecordPixels), tangleLights(), settings, lists),
              "maxBytes is 86399");
  settings.maxBytes += 1 + 16 * 48;  // to a multiple of 16 vertices
  EXPECT_TRUE(scene.draw(tangleView(kRecordPixels), tangleLights(), settings, lists));
}

INSTANTIATE_TEST_SUITE_P(Apis, TransformedStrands, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
