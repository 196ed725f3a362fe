// More hair objects in a view than fragments can tell apart.
#include <gtest/gtest.h>

#include <vector>

#include "pelage/random.h"
#include "support/pictures.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

constexpr uint32_t kCrowdColumns = 13, kCrowdRows = 10;  // of 130 objects
constexpr float kCrowdCell = 0.02f;                      // [m]

class Crowd : public SceneRunTest<> {
 protected:
  // Short strands in a cell of their own.
  static void addStrands(HairAsset& asset, uint32_t cell, float spread) {
    asset.verticesPerStrand = 4;
    pelage::Random random(cell + 1);
    const float x = (static_cast<float>(cell % kCrowdColumns) - 6) * kCrowdCell;
    const float y = (static_cast<float>(cell / kCrowdColumns) - 4.5f) * kCrowdCell;
    for (int strand = 0; strand < 3; ++strand) {
      const Float3 root = {x + spread * (random.uniform() - 0.5f),
                           y + spread * (random.uniform() - 0.5f), spread * random.uniform()};
      const Float3 way = {spread * (random.uniform() - 0.5f), spread * (random.uniform() - 0.5f),
                          0.1f * spread};
      for (int v = 0; v < 4; ++v) {
        const float share = static_cast<float>(v) / 3;
        asset.positions.push_back({root.x + share * way.x, root.y + share * way.y,
                                   root.z + share * way.z, v < 2 ? 0.0f : 1.0f});
      }
      ++asset.strandCount;
    }
  }
  static HairDef definition(uint32_t cell, bool alike) {
    HairDef def;
    def.settings.gravity = {0, 0, 0};
    def.material.rootColor = {0.6f, 0.3f, 0.1f};
    def.material.colorVariation = 0;
    def.material.opacity = 0.6f;
    def.material.fiberRadius = 0.0015f;
    if (!alike) def.material.primaryStrength = 0.2f + 0.002f * static_cast<float>(cell);
    return def;
  }
  std::vector<HairObject*> addCells(float spread, bool alike) {
    std::vector<HairObject*> objects;
    for (uint32_t cell = 0; cell < kCrowdColumns * kCrowdRows; ++cell) {
      HairAsset asset;
      addStrands(asset, cell, spread);
      expectOk(asset.process());
      objects.push_back(&run_.add(asset, definition(cell, alike)));
    }
    return objects;
  }
  RenderedImage render(Transparency method) {
    // 1.3 times as wide as high.
    const View view = cameraView(
        {.eye = {0, 0, 1}, .fov = 0.25f, .width = 130, .height = 100, .nearPlane = 0.1f});
    std::vector<PassList> lists;
    const Light light;
    expectOk(run_.scene.draw(view, {&light, 1}, {.method = method}, lists));
    const RenderTargetDef target = {.width = view.width, .height = view.height};
    return imageOf(run_.renderLists(lists, target), target);
  }
};

// Objects that shade differently, and do not overlap: all of them at once are the parts.
TEST_P(Crowd, IsThePictureOfItsParts) {
  const std::vector<HairObject*> objects = addCells(0.4f * kCrowdCell, false);
  run_.step();
  for (const Transparency method :
       {Transparency::kWindowed, Transparency::kTiles, Transparency::kHybrid8}) {
    for (HairObject* object : objects) object->visible = true;
    const RenderedImage all = render(method);
    std::vector<RenderedImage> parts;
    for (size_t first = 0; first < objects.size(); first += 50) {
      for (size_t i = 0; i < objects.size(); ++i)
        objects[i]->visible = i >= first && i < first + 50;
      parts.push_back(render(method));
    }
    size_t covered = 0, wrong = 0;
    for (size_t i = 0; i < all.pixels.size(); ++i) {
      Float4 sum = {};
      int owners = 0;
      for (const RenderedImage& part : parts) {
        if (!(part.pixels[i].w > 0)) continue;
        sum = part.pixels[i];
        ++owners;
      }
      ASSERT_LE(owners, 1) << "the objects of the test overlap";
      covered += owners;
      wrong += all.pixels[i] == sum ? 0 : 1;
    }
    EXPECT_GT(covered, 400u);
    EXPECT_EQ(wrong, 0u) << "method " << static_cast<int>(method);
  }
}

// Objects that shade alike, one over the other: they are exact among each other, as one object is.
TEST_P(Crowd, ThatShadesAlikeIsThePictureOfOneObject) {
  const std::vector<HairObject*> objects = addCells(6 * kCrowdCell, true);
  HairAsset asset;
  for (uint32_t cell = 0; cell < kCrowdColumns * kCrowdRows; ++cell)
    addStrands(asset, cell, 6 * kCrowdCell);
  expectOk(asset.process());
  HairObject& one = run_.add(asset, definition(0, true));
  run_.step();
  for (const Transparency method : {Transparency::kWindowed, Transparency::kTiles}) {
    one.visible = false;
    for (HairObject* object : objects) object->visible = true;
    const RenderedImage crowd = render(method);
    one.visible = true;
    for (HairObject* object : objects) object->visible = false;
    const RenderedImage expected = render(method);
    EXPECT_GT(coveredPixels(expected), 5000u);
    size_t wrong = 0;
    for (size_t i = 0; i < crowd.pixels.size(); ++i)
      wrong += crowd.pixels[i] == expected.pixels[i] ? 0 : 1;
    EXPECT_EQ(wrong, 0u) << "method " << static_cast<int>(method);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Crowd, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
