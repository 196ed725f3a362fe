// The pass lists and the memory of the methods with a fixed number of layers, without a GPU.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/scene.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/views.h"

namespace pelage::test {
namespace {

struct LayeredMethod {
  Transparency transparency;
  uint32_t layers;
  uint32_t bytesAPixel;
  std::vector<std::vector<std::string>> passes;  ///< [list]
};

std::vector<std::vector<std::string>> hybridPasses() {
  return {{"clear_hybrid", "hybrid_depths"}, {"hybrid_colors"}, {"hybrid_read"}};
}

const std::vector<LayeredMethod>& layeredMethods() {
  static const std::vector<LayeredMethod> all = {
      {Transparency::kHybrid4, 4, 48, hybridPasses()},
      {Transparency::kHybrid8, 8, 80, hybridPasses()},
      {Transparency::kHybrid16, 16, 144, hybridPasses()},
      {Transparency::kShortCut,
       3,
       28,
       {{"clear_short_cut", "short_cut_depths_alpha"},
        {"short_cut_resolve_depth"},
        {"short_cut_fill_colors"},
        {"short_cut_resolve_color"}}},
  };
  return all;
}

class LayeredTransparencyTest : public testing::Test {
 protected:
  LayeredTransparencyTest() {
    EXPECT_TRUE(scene_.addHair(makeAsset(), {}));
    view_ = cameraView({.eye = {0, 0, 3}, .fov = 1, .width = 200, .height = 100});
  }
  Result<void> draw(const TransparencySettings& settings) {
    lists_.clear();
    return scene_.draw(view_, lights_, settings, lists_);
  }
  std::vector<std::string> buffersOf(std::string_view prefix) const {
    std::vector<std::string> names;
    for (uint32_t i = 0; i < scene_.resources().end(); ++i) {
      const BufferDesc* desc = scene_.resources().find(scene_.resources().at(i));
      if (desc != nullptr && desc->name.starts_with(prefix)) names.push_back(desc->name);
    }
    return names;
  }

  Scene scene_;
  View view_;
  std::vector<Light> lights_ = {Light{}};
  std::vector<PassList> lists_;
};

TEST_F(LayeredTransparencyTest, EachPassIsInTheListInWhichWhatItReadsIsThere) {
  for (const LayeredMethod& method : layeredMethods()) {
    expectOk(draw({.method = method.transparency}));
    ASSERT_EQ(lists_.size(), method.passes.size());
    for (size_t i = 0; i < lists_.size(); ++i) {
      std::vector<std::string> names;
      for (const Pass& pass : lists_[i].passes) names.emplace_back(pass.name);
      EXPECT_EQ(names, method.passes[i]) << "list " << i;
      for (const Pass& pass : lists_[i].passes) {
        if (!isDraw(pass.kind)) continue;
        const bool last = i + 1 == lists_.size();
        EXPECT_EQ(pass.state.colorWrite, last) << pass.name;
        // ShortCut's second pass alone writes depth.
        EXPECT_EQ(pass.state.depthWrite, std::string(pass.name) == "short_cut_resolve_depth");
      }
    }
  }
}

TEST_F(LayeredTransparencyTest, BothDrawsOfTheStrandsAreTheSameButForThePixelKernel) {
  for (const LayeredMethod& method : layeredMethods()) {
    ASSERT_TRUE(draw({.method = method.transparency}));
    std::vector<const Pass*> draws;
    for (const PassList& list : lists_)
      for (const Pass& pass : list.passes)
        if (pass.kind == PassKind::kDraw) draws.push_back(&pass);
    ASSERT_EQ(draws.size(), 2u);
    EXPECT_EQ(draws[0]->kernel, draws[1]->kernel);
    EXPECT_EQ(draws[0]->state, draws[1]->state);
    EXPECT_EQ(draws[0]->instanceCount, draws[1]->instanceCount);
  }
}

TEST_F(LayeredTransparencyTest, OnlyTheMethodThatDrawsHasBuffersAndTheyAreWhatThePlanSays) {
  ASSERT_TRUE(draw({.method = Transparency::kStochastic}));
  EXPECT_TRUE(buffersOf("transparency/").empty());
  for (const LayeredMethod& method : layeredMethods()) {
    Scene scene;
    ASSERT_TRUE(scene.addHair(makeAsset(), {}));
    std::vector<PassList> lists;
    ASSERT_TRUE(scene.draw(view_, lights_, {.method = Transparency::kStochastic}, lists));
    const uint64_t before = scene.resources().totalBytes();
    ASSERT_TRUE(scene.draw(view_, lights_, {.method = method.transparency}, lists));
    const uint64_t bytes = scene.resources().totalBytes() - before;
    const auto plan = required(planTransparency(200, 100, {.method = method.transparency}));
    EXPECT_EQ(bytes, plan->bytes);
    EXPECT_EQ(plan->nodeCount, 0u);
    EXPECT_EQ(bytes / (200 * 100), method.bytesAPixel);
    EXPECT_EQ(scene.transparencyCounters(), BufferId::kInvalid) << "those are of linked lists";
    // A smaller view, and the same one again, when the lists before have run.
    const uint64_t version = scene.resources().version();
    const auto run = [&] {
      for (PassList& list : lists) {
        scene.finish(list);
        setDelivered(list.run);
      }
      lists.assign(1, {});
    };
    View smaller = view_;
    smaller.width = 20;
    run();
    ASSERT_TRUE(scene.draw(smaller, lights_, {.method = method.transparency}, lists));
    run();
    ASSERT_TRUE(scene.draw(view_, lights_, {.method = method.transparency}, lists));
    EXPECT_EQ(scene.resources().version(), version);
  }
}

TEST_F(LayeredTransparencyTest, WithoutHairInViewTheListsAreEmpty) {
  view_.worldToClip = lookAt({0, 0, 3}, {0, 0, 9}, {0, 1, 0}, 1, 1, 0.1f, 10);
  for (const LayeredMethod& method : layeredMethods()) {
    ASSERT_TRUE(draw({.method = method.transparency}));
    for (const PassList& list : lists_) EXPECT_TRUE(list.passes.empty());
  }
  EXPECT_TRUE(buffersOf("transparency/").empty());
}

TEST_F(LayeredTransparencyTest, ACapThatIsTooSmallIsRefusedWithTheWayOut) {
  for (const LayeredMethod& method : layeredMethods()) {
    TransparencySettings settings = {.method = method.transparency};
    const auto plan = required(planTransparency(200, 100, settings));
    settings.maxBytes = plan->bytes;
    EXPECT_TRUE(draw(settings));
    settings.maxBytes = plan->bytes - 1;
    Result<void> drawn = draw(settings);
    expectError(drawn, {"take " + std::to_string(plan->bytes) + " bytes", "fewer layers"});
    settings.maxBytes = plan->bytes;
    settings.maxBufferBytes = uint64_t{200} * 100 * 4 * std::max(method.layers, 4u);
    EXPECT_TRUE(draw(settings));
    --settings.maxBufferBytes;
    drawn = draw(settings);
    expectError(drawn, "maxBufferBytes is");
  }
}

}  // namespace
}  // namespace pelage::test
