// The picture of sample/engine_lights: the generated character in an engine's own lights, by every
// transparency method.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "device.h"
#include "image.h"
#include "image_difference.h"
#include "lit_character.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"

namespace {

using pelage::Api;
using pelage::Float4;
using pelage::RenderedImage;
using pelage::Transparency;
using pelage::test::brightness;
using pelage::test::required;

constexpr uint32_t kCharacterSize = 64;  // pixels
constexpr float kHairShare = 0.05f;      // of the character's strands
constexpr uint32_t kPixels = kCharacterSize * kCharacterSize;

struct Method {
  const char* name;
  Transparency transparency;
  uint32_t samples = 1;
};
constexpr Method kMethods[] = {
    {"alpha test", Transparency::kAlphaTest}, {"stochastic", Transparency::kStochastic, 4},
    {"windowed", Transparency::kWindowed},    {"hybrid 8", Transparency::kHybrid8},
    {"ShortCut", Transparency::kShortCut},    {"tiles", Transparency::kTiles}};

struct Lit {
  std::unique_ptr<pelage::HeadlessDevice> device;
  std::optional<engine_lights::LitCharacter> character;
};

class LitCharacterTest : public testing::TestWithParam<Api> {
 protected:
  // One an API for all tests: most of their time is that of making it and its pipelines.
  static std::map<Api, Lit>& all() {
    static std::map<Api, Lit> lit;
    return lit;
  }
  static void TearDownTestSuite() { all().clear(); }
  void SetUp() override {
    const auto [found, added] = all().try_emplace(GetParam());
    Lit& lit = found->second;
    if (added) {
      auto device = sample::createDevice({.api = GetParam()});
      if (!device) {
        EXPECT_EQ(device.error().code, pelage::ErrorCode::kUnsupported) << device.error().message;
        pelage::test::missingDevice(device.error().message);
      } else {
        lit.device = std::move(*device);
        auto character = required(engine_lights::LitCharacter::create(*lit.device, kHairShare));
        lit.character.emplace(*std::move(character));
      }
    }
    if (lit.device == nullptr)
      PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no " << pelage::apiName(GetParam()) << " device";
  }
  static bool hasTarget(const Method& method) {
    const Lit& lit = all()[GetParam()];
    return (lit.device->info().sampleCounts & method.samples) != 0;
  }
  static RenderedImage draw(const Method& method, const engine_lights::LightsOn& lights = {},
                            bool hair = true) {
    auto image = all()[GetParam()].character->draw({.size = kCharacterSize,
                                                    .method = method.transparency,
                                                    .samples = method.samples,
                                                    .hair = hair,
                                                    .lights = lights});
    EXPECT_TRUE(image) << method.name << ": " << image.error().message;
    return image ? *std::move(image)
                 : RenderedImage{kCharacterSize, kCharacterSize, std::vector<Float4>(kPixels)};
  }
};
// OpenGL ES has the code of OpenGL here, and tests/oit engine lights on it.
INSTANTIATE_TEST_SUITE_P(All, LitCharacterTest, testing::Values(Api::kVulkan, Api::kGl),
                         pelage::test::apiTestName);

// Pixels that hair changes.
struct HairSeen {
  uint32_t count = 0;
  double light = 0;  // mean brightness of them
};

HairSeen hairSeen(const RenderedImage& image, const RenderedImage& bald, float least = 0.05f) {
  HairSeen seen;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const Float4 &with = image.pixels[i], &without = bald.pixels[i];
    for (const float value : {with.x, with.y, with.z, with.w}) EXPECT_TRUE(std::isfinite(value));
    if (!(std::abs(brightness(with) - brightness(without)) > least)) continue;
    ++seen.count;
    seen.light += static_cast<double>(brightness(with));
  }
  seen.light /= std::max(seen.count, 1u);
  return seen;
}

// Light and methods are judged on one API: the picture is the same on all of them.
TEST_P(LitCharacterTest, IsNeitherBlackNorEmptyInAnyMethod) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const RenderedImage bald = draw(kMethods[2], {}, false);
  for (const Method& method : kMethods) {
    if (!hasTarget(method)) continue;
    const HairSeen seen = hairSeen(draw(method), bald, 0.02f);
    std::cout << method.name << ": hair in " << seen.count << " pixels, mean brightness "
              << seen.light << "\n";
    EXPECT_GT(seen.count, kPixels / 50) << method.name;
    EXPECT_GT(seen.light, 0.05) << method.name;
    EXPECT_LT(seen.light, 2.5) << method.name;
  }
}

TEST_P(LitCharacterTest, HasTheHairInTheShadowOfTheCascades) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  // One of each way to light fragments: of a list, of a layer, in compute.
  for (const Method& method : {kMethods[2], kMethods[3], kMethods[5]}) {
    // The sun alone.
    const engine_lights::LightsOn sun = {.spot = 0, .sky = 0},
                                  open = {.spot = 0, .sky = 0, .cascades = false};
    const RenderedImage shadowed = draw(method, sun), lit = draw(method, open);
    const RenderedImage bald = draw(method, open, false);
    uint32_t dark = 0, brighter = 0;
    for (uint32_t i = 0; i < kPixels; ++i) {
      const float with = brightness(shadowed.pixels[i]), without = brightness(lit.pixels[i]);
      // The shadow takes light and adds none; rounding of layers and half floats aside.
      brighter += with <= 1.02f * without + 0.02f ? 0 : 1;
      const bool isHair = std::abs(without - brightness(bald.pixels[i])) > 0.02f;
      dark += isHair && without > 0.05f && with < 0.5f * without ? 1 : 0;
    }
    std::cout << method.name << ": " << dark << " pixels of hair are in the shadow\n";
    EXPECT_EQ(brighter, 0u) << method.name;
    EXPECT_GT(dark, kPixels / 600) << method.name;
  }
}

TEST_P(LitCharacterTest, HasLightOfTheSpotAndOfTheSkyOnTheHair) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const Method& method = kMethods[2];
  const RenderedImage dark = draw(method, {.sun = 0, .spot = 0, .sky = 0});
  float largest = 0;
  for (const Float4& p : dark.pixels) {
    const float light = std::abs(brightness(p));
    largest = light <= largest ? largest : light;
  }
  EXPECT_EQ(largest, 0.0f);
  const engine_lights::LightsOn spot = {.sun = 0, .sky = 0}, sky = {.sun = 0, .spot = 0};
  for (const auto& [name, on] : {std::pair("spot", spot), std::pair("sky", sky)}) {
    // Little of either comes from where the hair is.
    const HairSeen seen = hairSeen(draw(method, on), draw(method, on, false), 0.01f);
    std::cout << name << ": hair in " << seen.count << " pixels\n";
    EXPECT_GT(seen.count, kPixels / 100) << name;
  }
}

TEST_P(LitCharacterTest, IsTheSamePictureInTheExactMethodsAndOnEveryApi) {
  const sample::ByteImage windowed = sample::encodeSrgb(draw(kMethods[2]));
  const sample::ByteImage tiles = sample::encodeSrgb(draw(kMethods[5]));
  const pelage::test::ImageDifference methods = pelage::test::difference(tiles, windowed, 24);
  std::cout << "tiles against windowed: " << methods << "\n";
  EXPECT_LE(methods.mean, 0.5);
  EXPECT_LE(methods.shareOff, 0.01);
  static std::map<std::string, sample::ByteImage> first;
  for (const auto& [name, picture] : {std::pair("windowed", windowed),
                                      {"tiles", tiles},
                                      {"hybrid 8", sample::encodeSrgb(draw(kMethods[3]))}}) {
    const sample::ByteImage& expected = first.try_emplace(name, picture).first->second;
    const pelage::test::ImageDifference apis = pelage::test::difference(picture, expected, 24);
    std::cout << name << " against the first API: " << apis << "\n";
    EXPECT_LE(apis.mean, 1.0);
    EXPECT_LE(apis.shareOff, 0.02);
  }
}

}  // namespace
