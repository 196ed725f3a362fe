// An engine's own lights, in every transparency method: those that return what pelage's lights
// return give the same picture, a constant gives that color, and what is missing is named.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "oit/shared_tangle.h"
#include "pelage/engine_lights.h"
#include "support/errors.h"
#include "test_lights/gpu_structs.h"
#include "test_lights/kernels.h"

namespace pelage::test {
namespace {

constexpr uint32_t kEnginePixels = 48;
constexpr Float3 kConstantColor = {0.75f, 0.25f, 0.5f};

class EngineLightsTest : public SharedTangleTest<> {
 protected:
  void fill(TangleRun& run) override { run.add({.strands = 300, .opacity = 0.6f}); }
  void SetUp() override {
    SharedTangleTest::SetUp();
    if (!hasDevice()) return;
    messages_ = device().messageCount();
    tangleRun().run.scene.setTier(device().info().tier);
  }
  void TearDown() override {
    if (hasDevice()) {
      EXPECT_EQ(device().messageCount(), messages_) << "the driver or a layer complained";
    }
  }
  static TransparencySettings settingsOf(const Method& method, const EngineLights* lights) {
    return {.method = method.transparency, .nodeCount = 1 << 15, .engineLights = lights};
  }
  RenderedImage render(const Method& method, const EngineLights* lights) {
    View view = tangleView(kEnginePixels);
    view.samples = method.samples;
    return tangleRun().render(view, settingsOf(method, lights), {.samples = method.samples});
  }
  // The lists of a view, which are not to run.
  std::vector<PassList> write(const Method& method, const EngineLights* lights) {
    std::vector<PassList> lists;
    expectOk(tangleRun().run.scene.draw(tangleView(kEnginePixels), tangleLights(),
                                        settingsOf(method, lights), lists));
    return lists;
  }

  // Lights of one color, whose parts come from a block, a buffer and two textures.
  EngineLights constantLights() {
    return testLights({kConstantColor.x, kConstantColor.y, kConstantColor.z, 1});
  }
  // Lights that return what pelage's return.
  EngineLights viewLights() { return testLights({}); }

 private:
  EngineLights testLights(const Float4& color) {
    test_lights::ConstantLight block = {};
    block.constantLight = color;
    const float scales[] = {0, 1, 0};
    if (scale_ == BufferId::kInvalid) scale_ = tangleRun().resources().add("scale", scales);
    // 1 in one texel, and what is not red is 1 on every face.
    std::vector<float> texels(size_t{3} * 2 * 2), cube(size_t{6} * 4 * 4);
    texels[(1 * 2 + 1) * 3 + 2] = 1;
    for (size_t i = 0; i < cube.size(); ++i) cube[i] = i % 4 == 0 ? 0.0f : 1.0f;
    const Result<TextureId> one = device().createTexture(
        {.width = 3, .height = 2, .layers = 2, .channels = 1, .texels = texels});
    const Result<TextureId> faces = device().createTexture(
        {.shape = TextureShape::kCube, .width = 2, .height = 2, .layers = 6, .texels = cube});
    EXPECT_TRUE(one) << one.error().message;
    EXPECT_TRUE(faces) << faces.error().message;
    EngineLights lights{.kernels = test_lights::allKernels()};
    if (!one || !faces) return lights;
    lights.resources = {NamedResource::constants("ConstantLight", block),
                        {.name = "g_constantScale", .buffer = {scale_, sizeof(scales)}},
                        {.name = "g_constantTexels", .texture = *one},
                        {.name = "g_constantCube", .texture = *faces},
                        {.name = "g_constantSampler", .texture = *faces}};
    return lights;
  }

  uint32_t messages_ = 0;
  BufferId scale_ = BufferId::kInvalid;
};
INSTANTIATE_TEST_SUITE_P(All, EngineLightsTest, testing::ValuesIn(kRuntimeApis), apiTestName);

TEST_P(EngineLightsTest, ThatReturnPelagesLightGiveItsPicture) {
  const EngineLights lights = viewLights();
  for (const Tier tier : {device().info().tier, Tier::kEs}) {
    tangleRun().run.scene.setTier(tier);
    for (const Method& method : kMethods) {
      if (!hasTarget(method)) continue;
      const RenderedImage own = render(method, nullptr);
      const RenderedImage theirs = render(method, &lights);
      EXPECT_GT(coveredPixels(own), kEnginePixels * kEnginePixels / 4) << method.name;
      EXPECT_LE(maxDifference(own, theirs), 1.0f / 1024) << method.name;
    }
  }
}

TEST_P(EngineLightsTest, ThatAreAConstantGiveThatColor) {
  const EngineLights lights = constantLights();
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const RenderedImage image = render(method, &lights);
    EXPECT_GT(coveredPixels(image), kEnginePixels * kEnginePixels / 4) << method.name;
    float worst = 0;
    for (const Float4& p : image.pixels) {
      for (const float d : {p.x - kConstantColor.x * p.w, p.y - kConstantColor.y * p.w,
                            p.z - kConstantColor.z * p.w})
        worst = std::abs(d) <= worst ? worst : std::abs(d);
    }
    std::cout << method.name << ": off by " << worst << "\n";
    // Layers have seven bits of a channel.
    EXPECT_LE(worst, 1.0f / 127) << method.name;
  }
}

TEST_P(EngineLightsTest, AddNeitherPassesNorBuffers) {
  const EngineLights lights = viewLights();
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const auto namesOf = [&](const EngineLights* theirs) {
      std::vector<std::string> names;
      for (const PassList& list : write(method, theirs))
        for (const Pass& pass : list.passes) names.emplace_back(pass.name);
      return names;
    };
    const std::vector<std::string> own = namesOf(nullptr);
    const uint32_t buffers = tangleRun().resources().count();
    EXPECT_EQ(namesOf(&lights), own) << method.name;
    EXPECT_EQ(tangleRun().resources().count(), buffers) << method.name;
  }
}

TEST_P(EngineLightsTest, AreInWhatIsPreparedAndSupported) {
  const EngineLights lights = viewLights();
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    expectOk(device().supports(settingsOf(method, &lights)));
    SceneFeatures features = {.transparency = {settingsOf(method, &lights)}};
    const Result<PassList> list = required(listToPrepare(features));
    uint32_t lit = 0;
    for (const Pass& pass : list->passes) {
      const Kernel* kernel = pass.pixel != nullptr ? pass.pixel->kernel : pass.kernel->kernel;
      lit += std::count(lights.kernels.begin(), lights.kernels.end(), kernel) > 0 ? 1 : 0;
    }
    EXPECT_GT(lit, 0u) << method.name;
  }
}

TEST_P(EngineLightsTest, NameWhatIsMissing) {
  const auto refused = [&](const Method& method, const EngineLights& lights,
                           std::initializer_list<std::string_view> words) {
    std::vector<PassList> lists;
    expectError(tangleRun().run.scene.draw(tangleView(kEnginePixels), tangleLights(),
                                           settingsOf(method, &lights), lists),
                words);
  };
  const EngineLights whole = constantLights();
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    refused(method, {.kernels = whole.kernels.subspan(1)}, {whole.kernels[0]->name});
    for (size_t i = 0; i < whole.resources.size(); ++i) {
      EngineLights lights = whole;
      lights.resources.erase(lights.resources.begin() + static_cast<std::ptrdiff_t>(i));
      refused(method, lights, {whole.resources[i].name, "EngineLights::resources"});
    }
  }
}

TEST_P(EngineLightsTest, AreRefusedWithATextureThatTheRuntimeDoesNotKnow) {
  EngineLights lights = constantLights();
  lights.resources[2].texture = newTextureId();
  for (const Method& method : kMethods) {
    if (method.samples > 1) continue;
    std::vector<PassList> lists = write(method, &lights);
    expectError(
        tangleRun().run.renderLists(lists, {.width = kEnginePixels, .height = kEnginePixels}),
        "g_constantTexels");
  }
}

TEST_P(EngineLightsTest, HaveTexturesOfTheSizesThatTheyCanHave) {
  const std::vector<float> texels(24);
  const TextureDef wrong[] = {
      {.width = 0, .height = 1, .texels = {}},
      {.width = 4096, .height = 1, .texels = texels},
      {.width = 2, .height = 3, .channels = 3, .texels = std::span(texels).first(18)},
      {.width = 2, .height = 3, .texels = std::span(texels).first(23)},
      {.shape = TextureShape::kCube, .width = 1, .height = 1, .layers = 5, .texels = texels},
      {.shape = TextureShape::kCube, .width = 1, .height = 2, .layers = 6, .texels = texels}};
  for (const TextureDef& def : wrong) {
    const Result<TextureId> made = device().createTexture(def);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace pelage::test
