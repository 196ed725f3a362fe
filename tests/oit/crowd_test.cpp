// More hair objects in a view than fragments can tell apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "pelage/random.h"
#include "support/required_devices.h"
#include "support/scene_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kColumns = 13, kRows = 10;  // of 130 objects
constexpr float kCell = 0.02f;                 // [m]

class Crowd : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    run_ = std::make_unique<SceneRun>(GetParam());
    if (run_->device() == nullptr)
      PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no " << apiName(GetParam());
  }

  // Short strands in a cell of their own.
  static void addStrands(HairAsset& asset, uint32_t cell, float spread) {
    Random random(cell + 1);
    const float x = (static_cast<float>(cell % kColumns) - 6) * kCell;
    const float y = (static_cast<float>(cell / kColumns) - 4.5f) * kCell;
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
  static HairAsset emptyAsset() {
    HairAsset asset;
    asset.verticesPerStrand = 4;
    return asset;
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
    for (uint32_t cell = 0; cell < kColumns * kRows; ++cell) {
      HairAsset asset = emptyAsset();
      addStrands(asset, cell, spread);
      expectOk(asset.process());
      objects.push_back(&run_->add(asset, definition(cell, alike)));
    }
    return objects;
  }
  RenderedImage render(Transparency method) {
    View view;
    view.eye = {0, 0, 1};
    view.worldToClip = lookAt(view.eye, {}, {0, 1, 0}, 0.25f, 1.3f, 0.1f, 5.0f);
    view.width = 130;
    view.height = 100;
    TransparencySettings settings;
    settings.method = method;
    std::vector<PassList> lists;
    const Light light;
    expectOk(run_->scene.draw(view, {&light, 1}, settings, lists));
    std::vector<const PassList*> pointers;
    for (PassList& list : lists) {
      run_->scene.finish(list);
      pointers.push_back(&list);
    }
    expectOk(run_->device()->update(run_->scene.resources()));
    Result<RenderedImage> image =
        run_->device()->render(pointers, {.width = view.width, .height = view.height});
    EXPECT_TRUE(image) << image.error().message;
    return image ? std::move(*image) : RenderedImage{};
  }

  std::unique_ptr<SceneRun> run_;
};

size_t coveredIn(const RenderedImage& image) {
  return static_cast<size_t>(std::count_if(image.pixels.begin(), image.pixels.end(),
                                           [](const Float4& p) { return p.w > 0; }));
}

// Objects that shade differently, and do not overlap: all of them at once are the parts.
TEST_P(Crowd, IsThePictureOfItsParts) {
  const std::vector<HairObject*> objects = addCells(0.4f * kCell, false);
  run_->step();
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
  const std::vector<HairObject*> objects = addCells(6 * kCell, true);
  HairAsset asset = emptyAsset();
  for (uint32_t cell = 0; cell < kColumns * kRows; ++cell) addStrands(asset, cell, 6 * kCell);
  expectOk(asset.process());
  HairObject& one = run_->add(asset, definition(0, true));
  run_->step();
  for (const Transparency method : {Transparency::kWindowed, Transparency::kTiles}) {
    one.visible = false;
    for (HairObject* object : objects) object->visible = true;
    const RenderedImage crowd = render(method);
    one.visible = true;
    for (HairObject* object : objects) object->visible = false;
    const RenderedImage expected = render(method);
    EXPECT_GT(coveredIn(expected), 5000u);
    size_t wrong = 0;
    for (size_t i = 0; i < crowd.pixels.size(); ++i)
      wrong += crowd.pixels[i] == expected.pixels[i] ? 0 : 1;
    EXPECT_EQ(wrong, 0u) << "method " << static_cast<int>(method);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Crowd, testing::ValuesIn(kApis),
                         [](const auto& api) { return std::string(apiName(api.param)); });

}  // namespace
}  // namespace pelage::test
