// The picture of sample/engine_shader: an engine's own hair shader around pelage's functions.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <optional>
#include <string>

#include "device.h"
#include "engine_picture.h"
#include "image.h"
#include "image_difference.h"
#include "support/gpu_fixture.h"

namespace {

using pelage::Api;
using pelage::RenderedImage;
using pelage::test::brightness;

constexpr uint32_t kHeadSize = 120;  // pixels
constexpr uint32_t kGuides = 400;

RenderedImage draw(pelage::HeadlessDevice& device, const engine_shader::PictureDef& def) {
  auto image = engine_shader::drawPicture(device, def);
  EXPECT_TRUE(image.ok()) << image.error().message;
  return image ? *std::move(image)
               : RenderedImage{kHeadSize, kHeadSize, {kHeadSize * kHeadSize, {0, 0, 0, 0}}};
}

// A device knows buffers by the ids of one scene, so each picture has one of its own.
std::optional<RenderedImage> drawOn(Api api, const engine_shader::PictureDef& def) {
  const auto device = sample::createDevice({.api = api});
  if (!device) {
    EXPECT_EQ(device.error().code, pelage::ErrorCode::kUnsupported) << device.error().message;
    pelage::test::missingDevice(device.error().message);
    return std::nullopt;
  }
  return draw(**device, def);
}

// All of it, once an API.
const std::optional<RenderedImage>& pictureOn(Api api) {
  static std::map<Api, std::optional<RenderedImage>> cache;
  const auto [found, made] = cache.try_emplace(api);
  if (made) found->second = drawOn(api, {.size = kHeadSize, .guides = kGuides});
  return found->second;
}

// All APIs draw the same picture, so tests look at the first that exists.
std::optional<Api> firstApi() {
  for (const Api api : pelage::test::kApis)
    if (pictureOn(api)) return api;
  return std::nullopt;
}

TEST(EngineShader, DrawsHairOnTheHead) {
  const std::optional<Api> api = firstApi();
  if (!api) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no device";
  const RenderedImage& hair = *pictureOn(*api);
  const auto bald = drawOn(*api, {.size = kHeadSize, .guides = kGuides, .hair = false});
  uint32_t changed = 0, beside = 0;
  for (size_t i = 0; i < hair.pixels.size(); ++i) {
    const pelage::Float4 &with = hair.pixels[i], &without = bald->pixels[i];
    for (const float value : {with.x, with.y, with.z, with.w}) ASSERT_TRUE(std::isfinite(value));
    changed += std::abs(brightness(with) - brightness(without)) > 0.05f ? 1 : 0;
    beside += with.w > 0 && without.w == 0 ? 1 : 0;
  }
  std::cout << changed << " pixels are other than those of the bald head, " << beside
            << " are beside it\n";
  EXPECT_GT(changed, kHeadSize * kHeadSize / 8);
  EXPECT_GT(beside, kHeadSize * kHeadSize / 50);
}

TEST(EngineShader, CastsTheShadowOfTheHairOnHairAndHead) {
  const std::optional<Api> api = firstApi();
  if (!api) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no device";
  const RenderedImage& shadowed = *pictureOn(*api);
  const auto bald = drawOn(*api, {.size = kHeadSize, .guides = kGuides, .hair = false});
  const auto lit = drawOn(*api, {.size = kHeadSize, .guides = kGuides, .keyShadow = false});
  uint32_t darkHair = 0, darkSkin = 0;
  for (size_t i = 0; i < shadowed.pixels.size(); ++i) {
    const float with = brightness(shadowed.pixels[i]), without = brightness(lit->pixels[i]);
    // The shadow takes light and adds none; rounding of half floats aside.
    ASSERT_LE(with, 1.01f * without + 0.01f) << "pixel " << i;
    if (!(with < 0.8f * without)) continue;
    (lit->pixels[i] == bald->pixels[i] ? darkSkin : darkHair) += 1;
  }
  std::cout << darkHair << " pixels with hair and " << darkSkin << " of skin are in the shadow\n";
  EXPECT_GT(darkHair, kHeadSize * kHeadSize / 50);
  EXPECT_GT(darkSkin, kHeadSize * kHeadSize / 400);
}

TEST(EngineShader, DrawsTheSamePictureOnEveryApi) {
  const std::optional<Api> first = firstApi();
  if (!first) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no device";
  const sample::ByteImage expected = sample::encodeSrgb(*pictureOn(*first));
  for (const Api api : pelage::test::kApis) {
    if (api == *first || !pictureOn(api)) continue;
    const pelage::test::ImageDifference d =
        pelage::test::difference(sample::encodeSrgb(*pictureOn(api)), expected, 24);
    std::cout << pelage::apiName(api) << " against " << pelage::apiName(*first) << ": " << d
              << "\n";
    EXPECT_LE(d.mean, 1.0);
    EXPECT_LE(d.shareOff, 0.02);
  }
}

}  // namespace
