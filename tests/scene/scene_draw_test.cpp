// Draws without a GPU: pass lists have no more than a view needs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/list_check.h"
#include "scene/scene_lists.h"
#include "support/not_numbers.h"
#include "support/views.h"

namespace pelage::test {
namespace {

class SceneDraw : public SceneListTest {
 protected:
  HairObject& add(const HairDef& def = {}) {
    id_ = addHair(makeAsset(40), def);
    return scene_.hair(id_);
  }

  static View viewFrom(float distance) {
    return cameraView({.eye = {0, 0.04f, distance},
                       .target = {0, 0.04f, 0},
                       .fov = 0.6f,
                       .width = 200,
                       .nearPlane = 0.01f,
                       .farPlane = 100});
  }

  /// Names of the passes of all lists; "|" between lists.
  std::string draw(const View& view, const TransparencySettings& settings = {}, Light light = {}) {
    lists_.clear();
    expectOk(scene_.draw(view, {&light, 1}, settings, lists_));
    std::string names;
    for (size_t i = 0; i < lists_.size(); ++i) {
      if (i > 0) names += "| ";
      names += passNames(lists_[i]);
    }
    return names;
  }

  RenderConstants constantsOfDraw() const {
    return blockOfDraw<RenderConstants>("RenderConstants");
  }

  template <class T>
  T blockOfDraw(std::string_view name) const {
    T constants = {};
    for (const Pass& pass : lists_[0].passes)
      if (pass.kind == PassKind::kDraw) constants = constantsOf<T>(lists_[0], pass, name);
    return constants;
  }

  HairId id_ = HairId::kInvalid;
  std::vector<PassList> lists_;
};

TEST_F(SceneDraw, ListsHaveThePassesOfTheirMethod) {
  add();
  const View view = viewFrom(0.5f);
  EXPECT_EQ(draw(view), "clear_ppll ppll_build | ppll_read ");
  EXPECT_EQ(draw(view, {.method = Transparency::kStochastic}), "strand_pixel ");
  EXPECT_EQ(draw(view, {.method = Transparency::kAlphaTest}), "strand_pixel ");
  Light shadowed = {.shadow = HairShadow::kDepth};
  EXPECT_EQ(draw(view, {.method = Transparency::kAlphaTest}, shadowed),
            "clear_strand_shadow splat_strand_depths strand_pixel ");
  shadowed.shadow = HairShadow::kDeep;
  EXPECT_EQ(draw(view, {.method = Transparency::kAlphaTest}, shadowed),
            "clear_strand_shadow splat_strand_depths splat_strand_opacity accumulate_strand_shadow "
            "strand_pixel ");
}

TEST_F(SceneDraw, PointAndSpotLightsHaveOneMapEach) {
  add();
  Light light = {.hasPosition = true, .position = {0, 1, 0}};
  EXPECT_EQ(draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light), "strand_pixel ");
  light.shadow = HairShadow::kDeep;
  const std::string passes =
      "clear_strand_shadow splat_strand_depths splat_strand_opacity accumulate_strand_shadow "
      "strand_pixel ";
  const auto view = [&] {
    EXPECT_EQ(draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light), passes);
    return blockOfDraw<StrandViewConstants>("StrandViewConstants");
  };
  EXPECT_EQ(view().shadowFaces[0].x, 1u);
  EXPECT_EQ(view().lightCones[0], (Float4{}));
  // In the hair it is a cube, of less than twice the size.
  light.position = {0, 0.04f, 0};
  EXPECT_EQ(view().shadowFaces[0].x, 6u);
  EXPECT_EQ(view().shadowSizes[0].x, light.shadowSize / 2);
  // A spot light needs a cube only where its cone is too wide for one map.
  light.direction = {0, 1, 0};
  light.outerConeAngle = 0.5f;
  EXPECT_EQ(view().shadowFaces[0].x, 1u);
  EXPECT_GT(view().lightCones[0].y, 0);
  light.outerConeAngle = 1.5f;
  EXPECT_EQ(view().shadowFaces[0].x, 6u);
  const std::vector<Light> lights(kMaxStrandShadows + 1, light);
  lists_.assign(1, {});
  EXPECT_FALSE(scene_.draw(viewFrom(0.5f), lights, {}, lists_));
}

TEST_F(SceneDraw, DepthMapsOfOpaqueGeometryAreCopiedWhereHairIsDrawn) {
  HairObject& hair = add();
  Light light;
  EXPECT_EQ(draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light), "strand_pixel ");
  const uint64_t bytes = scene_.resources().totalBytes();
  light.opaque.depth =
      scene_.resources().add({.name = "depth", .size = 64 * 32 * 4, .stride = sizeof(float)});
  light.opaque.width = 64;
  light.opaque.height = 32;
  EXPECT_EQ(draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light),
            "copy_opaque_shadow strand_pixel ");
  const auto constants = blockOfDraw<StrandViewConstants>("StrandViewConstants");
  EXPECT_EQ(constants.lightShadows[0].x, ~0u);
  EXPECT_EQ(constants.lightShadows[0].y, 1u);
  // The engine's map, and its copy in place of the words that are bound without any.
  EXPECT_LE(scene_.resources().totalBytes() - bytes, 2 * 64 * 32 * 4u);
  // A second view of the frame reads what the first one has copied.
  std::vector<PassList> second;
  ASSERT_TRUE(
      scene_.draw(viewFrom(0.4f), {&light, 1}, {.method = Transparency::kAlphaTest}, second));
  ASSERT_EQ(second[0].passes.size(), 1u);
  EXPECT_STREQ(second[0].passes[0].name, "strand_pixel");
  // Beside a map of hair, in one buffer.
  light.shadow = HairShadow::kDepth;
  EXPECT_EQ(draw(viewFrom(0.4f), {.method = Transparency::kAlphaTest}, light),
            "clear_strand_shadow splat_strand_depths copy_opaque_shadow strand_pixel ");
  EXPECT_EQ(blockOfDraw<StrandViewConstants>("StrandViewConstants").opaqueSizes[0].z, 1024u * 1024);

  // Engines that draw hair read their own map.
  PassList list;
  light.shadow = HairShadow::kNone;
  ASSERT_TRUE(scene_.castShadows({&light, 1}, list));
  EXPECT_TRUE(list.passes.empty());
  hair.visible = false;
  EXPECT_EQ(draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light), "");
  hair.visible = true;
  light.opaque.height = 33;
  lists_.assign(1, {});
  expectError(scene_.draw(viewFrom(0.5f), {&light, 1}, {}, lists_),
              "light 0: opaque.depth has 8192 bytes, but 64 x 33");
}

TEST_F(SceneDraw, ShadowsAreCastWithoutDrawsForShadersOfAnEngine) {
  HairObject& hair = add();
  EXPECT_EQ(scene_.shadowViews(), BufferId::kInvalid);
  Light plain, deep, depths, point;
  deep.shadow = point.shadow = HairShadow::kDeep;
  depths.shadow = HairShadow::kDepth;
  point.hasPosition = true;
  PassList list;
  const Light lights[] = {plain, deep, point, depths};
  const Result<uint32_t> cast = required(scene_.castShadows(lights, list));
  EXPECT_EQ(*cast, 3u);
  EXPECT_EQ(passNames(list),
            "clear_strand_shadow splat_strand_depths splat_strand_opacity accumulate_strand_shadow "
            "clear_strand_shadow splat_strand_depths splat_strand_opacity accumulate_strand_shadow "
            "clear_strand_shadow splat_strand_depths ");
  // One after the other, in the order of the lights.
  ASSERT_EQ(list.uploads.size(), 3u);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(list.uploads[i].buffer, scene_.shadowViews());
    EXPECT_EQ(list.uploads[i].offset, i * sizeof(StrandShadowView));
    StrandShadowView map;
    std::memcpy(&map, list.uploadData.data() + list.uploads[i].dataOffset, sizeof(map));
    EXPECT_EQ(map.layerCount, i < 2 ? deep.shadowLayers : 0u);
  }

  // Without hair there are no maps, but still the buffers that shaders have bound.
  hair.visible = false;
  Scene empty;
  for (Scene* scene : {&scene_, &empty}) {
    list.clear();
    const Result<uint32_t> none = required(scene->castShadows(lights, list));
    EXPECT_EQ(*none, 0u);
    EXPECT_TRUE(list.passes.empty());
    EXPECT_NE(scene->resources().find(scene->shadowWords()), nullptr);
    EXPECT_NE(scene->resources().find(scene->shadowViews()), nullptr);
  }
  hair.visible = true;
  const std::vector<Light> tooMany(kMaxStrandShadows + 1, deep);
  EXPECT_FALSE(scene_.castShadows(tooMany, list));
  plain.color.x = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(scene_.castShadows({&plain, 1}, list));
}

TEST_F(SceneDraw, WhatIsOutOfViewOrHiddenCostsNothing) {
  HairObject& hair = add();
  const uint64_t bytes = scene_.resources().totalBytes();
  View view = viewFrom(0.5f);
  // Looks away.
  view.worldToClip = lookAt(view.eye, {0, 0.04f, 1}, {0, 1, 0}, 0.6f, 1, 0.01f, 100);
  EXPECT_EQ(draw(view), "");
  // Left, right, above and below of the picture: one plane alone leaves it out each time.
  view = viewFrom(5);
  for (const Float3 target : {Float3{6, 0.04f, 0}, {-6, 0.04f, 0}, {0, 6, 0}, {0, -6, 0}}) {
    view.worldToClip = lookAt(view.eye, target, {0, 1, 0}, 0.6f, 1, 0.01f, 100);
    EXPECT_EQ(draw(view), "") << target.x << " " << target.y;
  }
  // Nearer than the near plane, and beyond the far one.
  for (const auto& [near, far] : {std::pair(10.0f, 100.0f), std::pair(0.01f, 2.0f)}) {
    view.worldToClip = lookAt(view.eye, {0, 0.04f, 0}, {0, 1, 0}, 0.6f, 1, near, far);
    EXPECT_EQ(draw(view), "") << near << " to " << far;
  }
  hair.visible = false;
  EXPECT_EQ(draw(viewFrom(0.5f)), "");
  hair.visible = true;
  hair.drawnStrands = 0;
  EXPECT_EQ(draw(viewFrom(0.5f)), "");
  EXPECT_EQ(scene_.resources().totalBytes(), bytes) << "buffers that no draw has needed";
}

TEST_F(SceneDraw, BuffersAreThoseOfTheMethodsThatAreUsed) {
  add();
  const View view = viewFrom(0.5f);
  draw(view, {.method = Transparency::kStochastic});
  EXPECT_EQ(scene_.transparencyCounters(), BufferId::kInvalid);
  const uint64_t before = scene_.resources().totalBytes();
  TransparencySettings settings = {.nodeCount = 1000};
  draw(view, settings);
  const auto plan = required(planTransparency(view.width, view.height, settings));
  EXPECT_EQ(plan->nodeCount, 1000u);
  EXPECT_EQ(scene_.resources().totalBytes() - before, plan->bytes);
  settings.spillTail = false;
  draw(view, settings);
  EXPECT_EQ(scene_.resources().totalBytes() - before,
            planTransparency(view.width, view.height, settings)->bytes);
}

TEST_F(SceneDraw, ListsFitIntoTheMemoryThatTheyAreGiven) {
  for (const uint64_t cap : {uint64_t{60} << 20, uint64_t{200} << 20, uint64_t{4} << 30}) {
    TransparencySettings settings = {.maxBytes = cap};
    const auto plan = required(planTransparency(1920, 1080, settings));
    EXPECT_LE(plan->bytes, cap);
    EXPECT_LE(uint64_t{plan->nodeCount} * 16, settings.maxBufferBytes);
    EXPECT_GT(plan->nodeCount, 0u);
  }
  // A buffer a device cannot bind is refused, and what helps is named.
  TransparencySettings settings = {.maxBytes = uint64_t{4} << 30};
  expectError(planTransparency(7680, 4320, settings), "maxBufferBytes");
  settings.spillTail = false;
  settings.maxBufferBytes = uint64_t{1} << 30;
  EXPECT_TRUE(planTransparency(7680, 4320, settings));
}

TEST_F(SceneDraw, NodesGrowWhereSomeWereMissingAndShrinkWhereFewWereUsed) {
  EXPECT_EQ(growNodes({.fragments = 900'000, .spilled = 0}, 1'000'000), 1'000'000u);
  EXPECT_GE(growNodes({.fragments = 3'000'000, .spilled = 2'000'000}, 1'000'000), 3'750'000u);
  const uint32_t shrunk = growNodes({.fragments = 100'000, .spilled = 0}, 1'000'000);
  EXPECT_GE(shrunk, 125'000u);
  EXPECT_LT(shrunk, 250'000u);
  EXPECT_EQ(growNodes({.fragments = 100'000, .spilled = 0}, shrunk), shrunk);
  EXPECT_LE(growNodes({.fragments = ~0u, .spilled = ~0u - 5}, 5), kMaxListNodes);
}

TEST_F(SceneDraw, FewerStrandsAreWiderAndCoverAsMuch) {  // K44
  HairObject& hair = add({.material = {}, .followHairs = {}});
  const View view = viewFrom(0.5f);
  uint32_t before = 0;
  for (const float share : {0.02f, 0.1f, 0.3f, 0.5f, 0.8f, 0.95f, 1.0f}) {
    hair.drawnShare = share;
    draw(view);
    const RenderConstants c = constantsOfDraw();
    double widths = 0;
    for (uint32_t s = 0; s < 40; ++s) {
      const double left = static_cast<double>(c.drawnStrands) - s;
      const double fading = static_cast<double>(c.fadingStrands);
      widths += static_cast<double>(c.strandWidening) *
                (fading > 0 ? std::clamp(left / fading, 0.0, 1.0) : (left > 0 ? 1.0 : 0.0));
    }
    // With 40 strands the sum of the last ones' widths is off by up to one of them.
    EXPECT_NEAR(widths, 40, 0.6 * static_cast<double>(c.strandWidening)) << share;
    const uint32_t drawn = lists_[0].passes.back().instanceCount;
    EXPECT_GE(drawn, before);
    EXPECT_LE(drawn, std::ceil(40 * share) + 1);
    before = drawn;
  }
  EXPECT_EQ(before, 40u);
  EXPECT_EQ(constantsOfDraw().strandWidening, 1.0f);
}

TEST_F(SceneDraw, TheShareForAViewFallsWithTheDistance) {
  HairObject& hair = add();
  hair.material.fiberRadius = 60e-6f;
  EXPECT_EQ(scene_.shareForView(id_, viewFrom(0.15f)), 1.0f);
  float before = 1;
  for (const float distance : {0.3f, 0.6f, 1.2f, 2.5f, 5.0f, 50.0f}) {
    const float share = scene_.shareForView(id_, viewFrom(distance));
    EXPECT_LE(share, before) << distance;
    EXPECT_GE(share, 1.0f / 64);
    before = share;
  }
  EXPECT_EQ(before, 1.0f / 64);
  const View view = viewFrom(2.5f);
  EXPECT_NEAR(scene_.shareForView(id_, view, 0.1f), 2 * scene_.shareForView(id_, view, 0.2f), 1e-4);
  EXPECT_EQ(scene_.shareForView(id_, view, 0), 1.0f);
  // Around the eye.
  EXPECT_EQ(scene_.shareForView(id_, viewFrom(0.0f)), 1.0f);
  View broken = viewFrom(1);
  broken.worldToClip.rows[3].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(scene_.shareForView(id_, broken), 1.0f);
}

TEST_F(SceneDraw, ShadowsAreAsDenseAsTheHairWhereverElseThereIsSome) {
  Light light = {.shadow = HairShadow::kDepth};
  const auto extinction = [&] {
    draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light);
    return blockOfDraw<StrandViewConstants>("StrandViewConstants").shadowDepths[0].z;
  };
  add();
  const float alone = extinction();
  EXPECT_GT(alone, 0);
  AffineTransform away;
  away.rows[0].w = 20;
  add().setBones({&away, 1});
  EXPECT_NEAR(extinction(), alone, 0.01f * alone);
}

TEST_F(SceneDraw, LightsSayHowTheirShadowsAreRead) {
  add();
  Light light = {.shadow = HairShadow::kDeep};
  const auto constants = [&] {
    draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light);
    return blockOfDraw<StrandViewConstants>("StrandViewConstants");
  };
  const StrandViewConstants first = constants();
  // In texels.
  const float texel = first.shadowDepths[0].w;
  EXPECT_GT(texel, 0);
  EXPECT_FLOAT_EQ(first.shadowDepths[0].y, Light().shadowBias * texel);
  light.shadowBias = 3;
  EXPECT_FLOAT_EQ(constants().shadowDepths[0].y, 3 * texel);
  // In meters.
  EXPECT_GT(first.shadowDepths[0].x, 0);
  light.shadowLayerRange = 0.0123f;
  EXPECT_EQ(constants().shadowDepths[0].x, 0.0123f);
  // Half the volume is hair twice as dense.
  light.shadow = HairShadow::kDepth;
  light.shadowVolume = 2e-3f;
  const float extinction = constants().shadowDepths[0].z;
  EXPECT_GT(extinction, 0);
  light.shadowVolume = 1e-3f;
  EXPECT_NEAR(constants().shadowDepths[0].z, 2 * extinction, 0.01f * extinction);
}

TEST_F(SceneDraw, OpaqueGeometryIsReadAsItsLightSays) {
  add();
  std::vector<Light> lights(3);
  for (const size_t i : {size_t{1}, size_t{2}}) {
    OpaqueShadow& map = lights[i].opaque;
    map.width = 8 * static_cast<uint32_t>(i);
    map.height = 16;
    map.depth = scene_.resources().add(
        {.name = "depth", .size = uint64_t{4} * map.width * map.height, .stride = sizeof(float)});
    map.worldToClip.rows[2] = {0, 0, -0.25f * static_cast<float>(i), 0.5f};
  }
  lights[2].opaque.bias = 0.03f;
  lights[2].opaque.reversedDepth = true;
  lists_.clear();
  ASSERT_TRUE(scene_.draw(viewFrom(0.5f), lights, {.method = Transparency::kAlphaTest}, lists_));
  const auto constants = blockOfDraw<StrandViewConstants>("StrandViewConstants");
  const uint32_t expected[] = {0, 1, 2};
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(constants.lightShadows[i].y, expected[i]);
  EXPECT_EQ(constants.opaqueSizes[0], (Uint4{8, 16, 0, 0}));
  EXPECT_EQ(constants.opaqueSizes[1], (Uint4{16, 16, 8 * 16, 1}));
  EXPECT_EQ(constants.opaqueBiases[0].x, OpaqueShadow{}.bias);
  EXPECT_EQ(constants.opaqueBiases[1].x, 0.03f);
  for (const size_t i : {size_t{1}, size_t{2}})
    for (size_t row = 0; row < 4; ++row)
      EXPECT_EQ(constants.opaqueRows[4 * (i - 1) + row], lights[i].opaque.worldToClip.rows[row]);
}

TEST_F(SceneDraw, BatchesAreOf64Materials) {
  const auto count = [&](const char* name) {
    size_t found = 0;
    for (const PassList& list : lists_) found += countPasses(list, name);
    return found;
  };
  std::vector<HairObject*> objects;
  for (int i = 0; i < 130; ++i) objects.push_back(&add());
  const View view = viewFrom(0.5f);
  // They shade alike.
  draw(view);
  EXPECT_EQ(lists_.size(), 2u);
  EXPECT_EQ(count("ppll_build"), 130u);
  EXPECT_EQ(count("ppll_read"), 1u);
  draw(view, {.method = Transparency::kTiles});
  EXPECT_EQ(lists_.size(), 2u);
  EXPECT_EQ(count("weigh_strand_tiles"), 1u);
  for (size_t i = 0; i < objects.size(); ++i)
    objects[i]->material.primaryShift = 0.001f * static_cast<float>(i);
  draw(view);
  EXPECT_EQ(lists_.size(), 6u);
  EXPECT_EQ(count("ppll_build"), 130u);
  EXPECT_EQ(count("ppll_read"), 3u);
  draw(view, {.method = Transparency::kTiles});
  EXPECT_EQ(lists_.size(), 4u);
  EXPECT_EQ(count("transform_strands"), 130u);
  EXPECT_EQ(count("weigh_strand_tiles"), 3u);
  EXPECT_NE(draw(view, {.method = Transparency::kHybrid4}), "");
  EXPECT_EQ(lists_.size(), 3u);
}

TEST_F(SceneDraw, ShadowMapsOverTheirCapAreRefusedOnce) {
  add();
  Light light;
  light.shadow = HairShadow::kDeep;  // 1024 x 1024 texels of 9 words
  const auto cast = [&] {
    lists_.assign(1, {});
    return scene_.draw(viewFrom(0.5f), {&light, 1}, {.method = Transparency::kAlphaTest}, lists_);
  };
  scene_.setShadowMemory(20 << 20);
  const uint64_t before = scene_.resources().totalBytes();
  expectError(cast(), "setShadowMemory() allows 20971520");
  EXPECT_EQ(scene_.resources().totalBytes(), before);
  EXPECT_TRUE(lists_[0].passes.empty());
  light.shadowSize = 512;
  EXPECT_TRUE(cast());
  const uint64_t small = scene_.resources().totalBytes();
  EXPECT_LE(small - before, uint64_t{20} << 20);
  // A map that the device had no memory for never ran: it goes, and does not stay too large.
  scene_.setShadowMemory(uint64_t{8} << 30);
  light.shadowSize = 8192;
  light.shadowLayers = 16;
  EXPECT_TRUE(cast());
  EXPECT_GT(scene_.resources().totalBytes(), uint64_t{4} << 30);
  light.shadowSize = 512;
  light.shadowLayers = 8;
  EXPECT_TRUE(cast());
  EXPECT_EQ(scene_.resources().totalBytes(), small);
}

TEST_F(SceneDraw, TellsTheKernelWhichAttributesAnObjectHas) {
  const std::vector<Float4> texels(4, {1, 1, 1, 1});
  for (const bool tiles : {false, true}) {
    for (uint32_t attributes = 0; attributes < 8; ++attributes) {
      HairAsset asset = makeAsset(40);
      HairDef def;
      if ((attributes & 1) != 0) asset.strandThickness.assign(asset.strandCount, 0.5f);
      if ((attributes & 2) != 0) asset.vertexColor.assign(asset.positions.size(), {1, 1, 1, 1});
      if ((attributes & 4) != 0) {
        asset.strandUv.assign(asset.strandCount, {0.5f, 0.5f});
        def.baseTexture = {2, 2, texels};
      }
      ASSERT_TRUE(asset.process());
      const Result<HairId> added = required(scene_.addHair(asset, def));
      draw(viewFrom(0.5f), {.method = tiles ? Transparency::kTiles : Transparency::kStochastic});
      const PassList& list = lists_[tiles ? 1 : 0];
      const Pass& pass = list.passes.front();
      EXPECT_STREQ(pass.kernel->kernel->name, tiles ? "transform_strands" : "strand_vertex");
      EXPECT_EQ(constantsOf<RenderConstants>(list, pass, "RenderConstants").strandAttributes,
                attributes);
      std::vector<BufferId> bound;
      for (const PassBinding& binding : list.bindingsOf(pass)) bound.push_back(binding.buffer);
      const HairBuffers& buffers = scene_.hair(*added).buffers();
      for (const BufferId buffer :
           {buffers.strandThickness, buffers.vertexColors, buffers.baseTexture}) {
        EXPECT_TRUE(buffer == BufferId::kInvalid ||
                    std::find(bound.begin(), bound.end(), buffer) != bound.end());
      }
      EXPECT_TRUE(scene_.removeHair(*added));
    }
  }
}

TEST_F(SceneDraw, RefusesLightsAndTexturesThatDoNotFit) {
  add();
  std::vector<Light> lights(kMaxStrandLights + 1);
  Result<void> drawn = scene_.draw(viewFrom(0.5f), lights, {}, lists_);
  expectError(drawn, "9 lights");
  lights.resize(kMaxStrandShadows + 1);
  for (Light& light : lights) light.shadow = HairShadow::kDepth;
  drawn = scene_.draw(viewFrom(0.5f), lights, {}, lists_);
  expectError(drawn, "shadow");
  lights.resize(1);
  lights[0].color.x = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(scene_.draw(viewFrom(0.5f), lights, {}, lists_));

  const std::vector<Float4> texels(6, {1, 1, 1, 1});
  HairAsset asset = makeAsset(3);
  HairDef def;
  def.baseTexture = {2, 2, texels};
  Result<HairId> added = scene_.addHair(asset, def);
  expectError(added, "6 texels for 2 x 2");
  def.baseTexture = {3, 2, texels};
  added = scene_.addHair(asset, def);
  expectError(added, "strandUv");
  asset.strandUv.assign(3, {0.5f, 0.5f});
  ASSERT_TRUE(asset.process());
  EXPECT_TRUE(scene_.addHair(asset, def));
}

/// A draw with one thing wrong, and what the message has to name.
struct WrongDraw {
  const char* words[2];
  std::function<void(View&, Light&, TransparencySettings&, StrandMaterial&)> make;
};

std::vector<WrongDraw> wrongDraws() {
  using V = View;
  using L = Light;
  using T = TransparencySettings;
  using M = StrandMaterial;
  std::vector<WrongDraw> all = {
      {{"TransparencySettings::method", "99"},
       [](V&, L&, T& t, M&) { t.method = static_cast<Transparency>(99); }},
      {{"epsilon", "nan"}, [](V&, L&, T& t, M&) { t.epsilon = kNan; }},
      {{"View::width", "0 x 200"}, [](V& v, L&, T&, M&) { v.width = 0; }},
      {{"view: samples", "0"}, [](V& v, L&, T&, M&) { v.samples = 0; }},
      {{"view: samples", "3"}, [](V& v, L&, T&, M&) { v.samples = 3; }},
      {{"view: samples", "16"}, [](V& v, L&, T&, M&) { v.samples = 16; }},
      {{"view: eye", "nan"}, [](V& v, L&, T&, M&) { v.eye.y = kNan; }},
      {{"view: begins at", "0.5"}, [](V& v, L&, T&, M&) { v.x = 0.5f; }},
      {{"view: begins at", "nan"}, [](V& v, L&, T&, M&) { v.y = kNan; }},
      {{"whole numbers", "-1"}, [](V& v, L&, T&, M&) { v.x = -1; }},
      {{"whole numbers", "65536"}, [](V& v, L&, T&, M&) { v.y = 65536; }},
      {{"worldToClip", "no inverse"}, [](V& v, L&, T&, M&) { v.worldToClip.rows[3] = {}; }},
      {{"light 0: direction", "nan"}, [](V&, L& l, T&, M&) { l.direction.z = kNan; }},
      {{"light 0: direction", "inf"}, [](V&, L& l, T&, M&) { l.direction.x = kInf; }},
      {{"light 0: direction", "length > 0"}, [](V&, L& l, T&, M&) { l.direction = {}; }},
      {{"light 0: color", "inf"}, [](V&, L& l, T&, M&) { l.color.x = -kInf; }},
      {{"light 0: ambient", "nan"}, [](V&, L& l, T&, M&) { l.ambient.y = kNan; }},
      {{"light 0: environment.l21", "nan"}, [](V&, L& l, T&, M&) { l.environment.l21.z = kNan; }},
      {{"light 0: position", "nan"}, [](V&, L& l, T&, M&) { l.position.y = kNan; }},
      {{"light 0: shadow", "77"}, [](V&, L& l, T&, M&) { l.shadow = HairShadow{77}; }},
      {{"light 0: outerConeAngle", "nan"}, [](V&, L& l, T&, M&) { l.outerConeAngle = kNan; }},
      {{"light 0: outerConeAngle", "1.6"}, [](V&, L& l, T&, M&) { l.outerConeAngle = 1.6f; }},
      {{"light 0: outerConeAngle", "hasPosition"},
       [](V&, L& l, T&, M&) { l.outerConeAngle = 0.5f; }},
      {{"light 0: innerConeAngle", "0.5"}, [](V&, L& l, T&, M&) { l.innerConeAngle = 0.5f; }},
      {{"light 0: innerConeAngle", "nan"}, [](V&, L& l, T&, M&) { l.innerConeAngle = kNan; }},
      {{"light 0: direction", "nan"},
       [](V&, L& l, T&, M&) {
         l.hasPosition = true;
         l.outerConeAngle = 0.5f;
         l.direction.x = kNan;
       }},
      {{"'hair': material.model", "9"}, [](V&, L&, T&, M& m) { m.model = ShadingModel{9}; }},
      {{"'hair': material.rootColor", "nan"}, [](V&, L&, T&, M& m) { m.rootColor.x = kNan; }},
      {{"'hair': material.fiberRadius", "inf"}, [](V&, L&, T&, M& m) { m.fiberRadius = kInf; }},
      {{"'hair': material.refractiveIndex", "nan"},
       [](V&, L&, T&, M& m) { m.refractiveIndex = kNan; }},
  };
  const std::tuple<const char*, float M::*, float, const char*> materials[] = {
      {"material.opacity is -1", &M::opacity, -1.0f, "in 0..1"},
      {"material.opacity is 5", &M::opacity, 5.0f, "in 0..1"},
      {"material.fiberRadius is 0", &M::fiberRadius, 0.0f, "above 0"},
      {"material.fiberRadius is -1", &M::fiberRadius, -1.0f, "above 0"},
      {"material.tipRadiusRatio is 100", &M::tipRadiusRatio, 100.0f, "in 0..1"},
      {"material.refractiveIndex is 1", &M::refractiveIndex, 1.0f, "above 1"},
      {"material.longitudinalRoughness is -1", &M::longitudinalRoughness, -1.0f, "in 0..1"},
      {"material.azimuthalRoughness is 2", &M::azimuthalRoughness, 2.0f, "in 0..1"},
      {"material.primaryExponent is 0", &M::primaryExponent, 0.0f, "in 1..10000"},
      {"material.secondaryExponent is 0", &M::secondaryExponent, 0.0f, "in 1..10000"},
      {"material.multipleScattering is 2", &M::multipleScattering, 2.0f, "in 0..1"},
      {"material.ambientStrength is 65", &M::ambientStrength, 65.0f, "in 0..64"},
      {"material.cuticleTilt is nan", &M::cuticleTilt, kNan, "finite"},
      {"material.tipShare is nan", &M::tipShare, kNan, "in 0..1"},
  };
  for (const auto& [name, field, value, range] : materials)
    all.push_back({{name, range}, [field, value](V&, L&, T&, M& m) { m.*field = value; }});
  const auto deep = [&](const char* name, const char* value, auto set) {
    all.push_back({{name, value}, [set](V&, L& l, T&, M&) {
                     l.shadow = HairShadow::kDeep;
                     set(l);
                   }});
  };
  deep("light 0: shadowSize is 3", "4..8192", [](L& l) { l.shadowSize = 3; });
  deep("light 0: shadowSize is 8193", "4..8192", [](L& l) { l.shadowSize = 8193; });
  deep("light 0: shadowLayers is 0", "1..16", [](L& l) { l.shadowLayers = 0; });
  deep("light 0: shadowLayers is 17", "1..16", [](L& l) { l.shadowLayers = 17; });
  for (float L::*field : {&L::shadowBias, &L::shadowLayerRange, &L::shadowVolume}) {
    const char* name = field == &L::shadowBias         ? "light 0: shadowBias"
                       : field == &L::shadowLayerRange ? "light 0: shadowLayerRange"
                                                       : "light 0: shadowVolume";
    deep(name, "nan", [field](L& l) { l.*field = kNan; });
    deep(name, "inf", [field](L& l) { l.*field = kInf; });
    deep(name, "-1", [field](L& l) { l.*field = -1; });
  }
  const auto opaque = [&](const char* name, const char* value, auto set) {
    all.push_back({{name, value}, [set](V&, L& l, T&, M&) {
                     l.opaque = {.depth = BufferId{1}, .width = 1, .height = 1};
                     set(l.opaque);
                   }});
  };
  opaque("light 0: opaque.width", "0 x 1", [](OpaqueShadow& o) { o.width = 0; });
  opaque("opaque.height", "1 x 8193", [](OpaqueShadow& o) { o.height = 8193; });
  opaque("opaque.worldToClip", "not finite",
         [](OpaqueShadow& o) { o.worldToClip.rows[2].z = kInf; });
  opaque("opaque.bias", "-1", [](OpaqueShadow& o) { o.bias = -1; });
  opaque("opaque.bias", "nan", [](OpaqueShadow& o) { o.bias = kNan; });
  opaque("opaque.depth", "has 0 bytes", [](OpaqueShadow& o) { o.depth = BufferId{9999}; });
  for (int row = 0; row < 4; ++row) {
    for (const float bad : {kNan, kInf, -kInf}) {
      all.push_back({{"worldToClip", "not finite"},
                     [row, bad](V& v, L&, T&, M&) { v.worldToClip.rows[row].w = bad; }});
    }
  }
  return all;
}

TEST_F(SceneDraw, RefusesByNameWhatIsNoNumberAndNoValueOfItsEnum) {
  HairObject& hair = add();
  const StrandMaterial good = hair.material;
  PassList moved;
  ASSERT_TRUE(scene_.simulate(1.0f / 60, moved));
  const uint64_t bytes = scene_.resources().totalBytes();
  for (const WrongDraw& wrong : wrongDraws()) {
    View view = viewFrom(0.5f);
    Light light;
    TransparencySettings settings;
    wrong.make(view, light, settings, hair.material);
    std::vector<PassList> lists(1);
    const Result<void> drawn = scene_.draw(view, {&light, 1}, settings, lists);
    ASSERT_FALSE(drawn) << wrong.words[0];
    EXPECT_EQ(drawn.error().code, ErrorCode::kInvalidArgument);
    for (const char* word : wrong.words)
      EXPECT_NE(drawn.error().message.find(word), std::string::npos)
          << word << ": " << drawn.error().message;
    EXPECT_TRUE(lists[0].passes.empty());
    EXPECT_EQ(scene_.resources().totalBytes(), bytes) << wrong.words[0];
    // A frame says the same, and takes a good view afterwards.
    Result<Frame> frame = required(scene_.simulate(0));
    const Result<uint32_t> refused = frame->draw(view, {&light, 1}, settings);
    ASSERT_FALSE(refused) << wrong.words[0];
    EXPECT_EQ(refused.error().message, drawn.error().message);
    hair.material = good;
    EXPECT_EQ(frame->viewCount(), 0u);
  }
  EXPECT_NE(draw(viewFrom(0.5f)), "");
}

TEST_F(SceneDraw, RefusesNumbersOfStrandsThatAreOutOfRange) {
  HairObject& hair = add();
  PassList list;
  expectOk(scene_.simulate(1.0f / 60, list));
  const auto expectRefused = [&](const char* words) {
    const Light light = {.shadow = HairShadow::kDepth};
    PassList drawn;
    expectError(scene_.draw(viewFrom(0.5f), light, drawn), words);
    expectError(scene_.drawDepth(viewFrom(0.5f), {}, drawn), words);
    expectError(scene_.castShadows({&light, 1}, drawn), words);
  };
  for (const float share : {kNan, -3.0f, 1.5f}) {
    hair.drawnShare = share;
    expectRefused("'hair': drawnShare is");
  }
  hair.drawnShare = 1;
  hair.drawnStrands = 1000000000;
  expectRefused("'hair': drawnStrands is 1000000000");
  hair.drawnStrands = hair.strandCount();
  EXPECT_NE(draw(viewFrom(0.5f)), "");
}

TEST_F(SceneDraw, RefusesTheSameLightsForShadowsAndColliders) {
  add();
  PassList list;
  Light light = {.shadow = HairShadow::kDepth};
  light.direction = {};
  EXPECT_FALSE(scene_.castShadows({&light, 1}, list));
  EXPECT_TRUE(list.passes.empty());
  EXPECT_FALSE(scene_.draw(viewFrom(0.5f), light, list));
  // A point light has no direction, and one of any length is as good as another.
  light.hasPosition = true;
  EXPECT_TRUE(scene_.draw(viewFrom(0.5f), light, list));
  light.hasPosition = false;
  const auto directionOf = [&](float length) {
    light.direction = {0, 3 * length, 4 * length};
    draw(viewFrom(0.5f), {.method = Transparency::kAlphaTest}, light);
    return blockOfDraw<StrandViewConstants>("StrandViewConstants").lightDirections[0];
  };
  for (const float length : {1e-38f, 1e-30f, 1e-15f, 1.0f, 1e15f, 1e30f, 5e37f}) {
    const Float4 direction = directionOf(length);
    EXPECT_NEAR(direction.y, 0.6f, 1e-6f) << length;
    EXPECT_NEAR(direction.z, 0.8f, 1e-6f) << length;
  }
}

TEST_F(SceneDraw, AListIsDrawnIntoTheViewportOfItsView) {
  add();
  View view = viewFrom(0.5f);
  view.x = 8;
  draw(view);
  for (const PassList& list : lists_) {
    const PixelArea area = {8, 0, 200, 200};
    EXPECT_EQ(list.area, area);
    EXPECT_TRUE(checkArea(list, area));
    for (const PixelArea& wrong :
         {PixelArea{8, 0, 300, 200}, PixelArea{8, 0, 200, 199}, PixelArea{0, 0, 200, 200}}) {
      expectError(checkArea(list, wrong), "200 x 200 at (8, 0)");
    }
  }
  // Another viewport in the same list.
  PassList list;
  const Light light;
  ASSERT_TRUE(scene_.draw(view, light, list));
  const size_t passes = list.passes.size();
  view.width = 100;
  expectError(scene_.draw(view, light, list), "100 x 200");
  EXPECT_EQ(list.passes.size(), passes);
  list.clear();
  EXPECT_TRUE(scene_.draw(view, light, list));
}

}  // namespace
}  // namespace pelage::test
