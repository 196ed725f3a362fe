// Golden images: the sample's scene at a small size, on every API, against pictures in images/.
// A failing test writes what it saw, the difference and the golden into the build folder. After a
// change that is meant, run the test with PELAGE_UPDATE_GOLDEN=1 and look at the new pictures.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "asset_files.h"
#include "demo_scene.h"
#include "device.h"
#include "image_difference.h"
#include "png_file.h"
#include "support/required_devices.h"
#include "test_tier.h"

namespace {

using pelage::Api;
using pelage::test::difference;
using pelage::test::ImageDifference;
using sample::ByteImage;

constexpr uint32_t kSize = 160;  // pixels
constexpr uint32_t kSamples = 4;
// Pixels differ by more than this where a strand covers one sample more on another rasteriser.
constexpr uint32_t kThreshold = 24;       // 1/255
constexpr double kMeanTolerance = 1.0;    // 1/255
constexpr double kShareTolerance = 0.02;  // of the pixels may be over the threshold
constexpr Api kApis[] = {Api::kVulkan, Api::kGl, Api::kGles};

// Frames of the groom that are compared: at rest, in the swing to one side, in a nod. The
// sanitizers see nothing new in a hundred frames more.
#if defined(__SANITIZE_ADDRESS__)
const std::vector<uint32_t> kGroomFrames = {10, 45};
#else
const std::vector<uint32_t> kGroomFrames = {10, 45, 185};
#endif
const std::vector<uint32_t> kMohawkFrames = {45};
// The same groom with sorted transparency and shadows; nothing in it is random.
const std::vector<uint32_t> kSortedFrames = {45};

// The character while it shakes its head; long hair flies.
const std::vector<uint32_t> kCharacterFrames = {20};

using Pictures = std::map<uint32_t, ByteImage>;
using MakeScene = std::function<pelage::Result<sample::DemoScene>()>;

pelage::Result<sample::DemoScene> sceneOf(const pelage::Result<sample::DemoAssets>& assets) {
  if (!assets) return assets.error();
  return sample::DemoScene::create(*assets, {});
}

pelage::Result<sample::DemoScene> groomScene() {
  static const auto assets = [] {
    pelage::GroomDef def;
    def.strandCount = 400;
    def.verticesPerStrand = 16;
    def.headCellSize = 0.006f;
    return sample::generateAssets(def);
  }();
  return sceneOf(assets);
}

std::filesystem::path ratboy(const char* name) {
  return std::filesystem::path(PELAGE_TEST_DATA_DIR) / "ratboy" / name;
}

pelage::Result<sample::DemoScene> mohawkScene() {
  static const auto files = [] {
    std::vector<std::string> warnings;
    return pelage::program::loadAssetFiles({.hairs = {ratboy("Ratboy_mohawk.tfx")},
                                            .bones = {ratboy("Ratboy_mohawk.tfxbone")},
                                            .repair = true},
                                           warnings);
  }();
  if (!files) return files.error();
  return sample::DemoScene::create(sample::FileAssets{*files, {}}, {});
}

pelage::Result<pelage::Character> smallCharacter() {
  pelage::CharacterDef def;
  def.cellSize = 0.006f;
  def.colliderCellSize = 0.012f;
  def.longHair = {200, 16, 0.34f};
  def.fur = {700, 6, 0.04f};
  def.mohawk = {120, 8, 0.095f};
  return pelage::generateCharacter(def);
}

pelage::Result<sample::DemoScene> characterScene() {
  static const auto character = smallCharacter();
  if (!character) return character.error();
  sample::DemoDef demo;
  demo.motion = pelage::CharacterMotion::kHeadShake;
  return sample::DemoScene::create(*character, demo);
}

/// The frames of a run that are compared, by how they are drawn.
struct Shots {
  std::vector<uint32_t> stochastic, sorted;
};

bool contains(const std::vector<uint32_t>& frames, uint32_t frame) {
  return std::find(frames.begin(), frames.end(), frame) != frames.end();
}

/// Draws what has been simulated.
pelage::Result<ByteImage> draw(pelage::HeadlessDevice& device, sample::DemoScene& demo,
                               bool sorted) {
  demo.light.shadow = sorted ? pelage::HairShadow::kDeep : pelage::HairShadow::kNone;
  pelage::TransparencySettings settings;
  settings.method = sorted ? pelage::Transparency::kWindowed : pelage::Transparency::kStochastic;
  settings.nodeCount = 1 << 20;
  pelage::RenderTargetDef target;
  target.width = target.height = kSize;
  target.samples = sorted ? 1 : kSamples;
  const pelage::View view = sample::makeView(demo.camera(1), kSize, kSize, target.samples);
  std::vector<pelage::PassList> lists;
  if (auto done = demo.castOpaqueShadow(device); !done) return done.error();
  if (auto done = demo.draw(view, settings, lists); !done) return done.error();
  std::vector<const pelage::PassList*> pointers;
  for (pelage::PassList& list : lists) {
    demo.finish(list);
    pointers.push_back(&list);
  }
  if (auto done = device.update(demo.resources()); !done) return done.error();
  auto image = device.render(pointers, target, nullptr);
  if (!image) return image.error();
  sample::compositeOver(*image, {});
  return sample::encodeSrgb(*image);
}

struct RunPictures {
  Pictures stochastic, sorted;
};

pelage::Result<RunPictures> render(pelage::HeadlessDevice& device, const MakeScene& makeScene,
                                   const Shots& shots) {
  auto demo = makeScene();
  if (!demo) return demo.error();
  demo->setTier(device.info().tier);
  uint32_t last = 0;
  for (const auto* frames : {&shots.stochastic, &shots.sorted})
    if (!frames->empty()) last = std::max(last, frames->back());
  RunPictures pictures;
  pelage::PassList list;
  for (uint32_t frame = 1; frame <= last; ++frame) {
    list.clear();
    if (auto done = demo->advance(list); !done) return done.error();
    demo->finish(list);
    if (auto done = device.update(demo->resources()); !done) return done.error();
    if (auto done = device.execute(list); !done) return done.error();
    for (const bool sorted : {false, true}) {
      if (!contains(sorted ? shots.sorted : shots.stochastic, frame)) continue;
      auto picture = draw(device, *demo, sorted);
      if (!picture) return picture.error();
      (sorted ? pictures.sorted : pictures.stochastic)[frame] = std::move(*picture);
    }
  }
  return pictures;
}

// Pictures of one asset on one API; nothing, with the reason, when there is no such device.
struct Rendered {
  bool available = false;
  std::string why;
  Pictures pictures;
};

struct RenderedRun {
  Rendered stochastic, sorted;
};

RenderedRun renderOn(Api api, const MakeScene& makeScene, const Shots& shots) {
  RenderedRun result;
  auto device = sample::createDevice({.api = api, .maxTier = pelage::test::tierOfTests()});
  if (!device) {
    EXPECT_EQ(device.error().code, pelage::ErrorCode::kUnsupported) << device.error().message;
    result.stochastic.why = result.sorted.why = device.error().message;
    return result;
  }
  auto pictures = render(**device, makeScene, shots);
  EXPECT_TRUE(pictures.ok()) << pictures.error().message;
  if (!pictures) return result;
  result.stochastic = {true, {}, std::move(pictures->stochastic)};
  result.sorted = {true, {}, std::move(pictures->sorted)};
  return result;
}

/// Once for each API.
const RenderedRun& cached(std::map<Api, RenderedRun>& cache, Api api, const MakeScene& makeScene,
                          const Shots& shots) {
  const auto found = cache.find(api);
  if (found != cache.end()) return found->second;
  return cache[api] = renderOn(api, makeScene, shots);
}

const RenderedRun& groomRunOn(Api api) {
  static std::map<Api, RenderedRun> cache;
  return cached(cache, api, groomScene, {kGroomFrames, kSortedFrames});
}
const Rendered& groomOn(Api api) { return groomRunOn(api).stochastic; }
const Rendered& sortedOn(Api api) { return groomRunOn(api).sorted; }

const Rendered& mohawkOn(Api api) {
  static std::map<Api, RenderedRun> cache;
  return cached(cache, api, mohawkScene, {kMohawkFrames, {}}).stochastic;
}

const Rendered& characterOn(Api api) {
  static std::map<Api, RenderedRun> cache;
  return cached(cache, api, characterScene, {{}, kCharacterFrames}).sorted;
}

std::filesystem::path goldenPath(const std::string& name) {
  return std::filesystem::path(PELAGE_SOURCE_DIR) / "tests/golden/images" / (name + ".png");
}

void keepForInspection(const std::string& name, const ByteImage& actual, const ByteImage& golden) {
  const std::filesystem::path folder = PELAGE_GOLDEN_OUTPUT_DIR;
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* what, const ByteImage& image) {
    const std::string path = (folder / (name + "_" + what + ".png")).string();
    const auto written = sample::writePng(path, image);
    std::cout << "  " << (written ? path : written.error().message) << "\n";
  };
  write("actual", actual);
  write("golden", golden);
  write("difference", pelage::test::differenceImage(actual, golden));
}

void compareWithGolden(const std::string& name, const std::string& api, const ByteImage& actual) {
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) {
    const auto written = sample::writePng(goldenPath(name).string(), actual);
    ASSERT_TRUE(written.ok()) << written.error().message;
    return;
  }
  const auto golden = sample::readPng(goldenPath(name).string());
  ASSERT_TRUE(golden.ok()) << golden.error().message;
  ASSERT_EQ(golden->width, actual.width);
  ASSERT_EQ(golden->height, actual.height);
  const ImageDifference d = difference(actual, *golden, kThreshold);
  std::cout << name << " on " << api << ": " << d << "\n";
  EXPECT_LE(d.mean, kMeanTolerance);
  EXPECT_LE(d.shareOff, kShareTolerance);
  if (d.mean > kMeanTolerance || d.shareOff > kShareTolerance)
    keepForInspection(name + "_" + api, actual, *golden);
}

void expectGroom(Api api) {
  const Rendered& groom = groomOn(api);
  if (!groom.available) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << groom.why;
  for (const auto& [frame, picture] : groom.pictures)
    compareWithGolden("groom_" + std::to_string(frame), pelage::apiName(api), picture);
}

void expectSorted(Api api) {
  const Rendered& groom = sortedOn(api);
  if (!groom.available) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << groom.why;
  for (const auto& [frame, picture] : groom.pictures)
    compareWithGolden("sorted_" + std::to_string(frame), pelage::apiName(api), picture);
}

void expectCharacter(Api api) {
  const Rendered& character = characterOn(api);
  if (!character.available) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << character.why;
  for (const auto& [frame, picture] : character.pictures)
    compareWithGolden("character_" + std::to_string(frame), pelage::apiName(api), picture);
}

void expectAgreement(const std::string& name, const Rendered& (*renderedOn)(Api)) {
  for (size_t i = 0; i < std::size(kApis); ++i)
    for (size_t j = i + 1; j < std::size(kApis); ++j) {
      const Rendered& a = renderedOn(kApis[i]);
      const Rendered& b = renderedOn(kApis[j]);
      if (!a.available || !b.available)
        PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << (a.available ? b.why : a.why);
      for (const auto& [frame, picture] : a.pictures) {
        const ImageDifference d = difference(picture, b.pictures.at(frame), kThreshold);
        std::cout << name << " frame " << frame << ", " << pelage::apiName(kApis[i]) << " and "
                  << pelage::apiName(kApis[j]) << ": " << d << "\n";
        EXPECT_LE(d.mean, kMeanTolerance);
        EXPECT_LE(d.shareOff, kShareTolerance);
      }
    }
}

TEST(Golden, TheGroomOnVulkanLooksAsItDid) { expectGroom(Api::kVulkan); }
TEST(Golden, TheGroomOnGlLooksAsItDid) { expectGroom(Api::kGl); }
TEST(Golden, TheGroomOnGlesLooksAsItDid) { expectGroom(Api::kGles); }
TEST(Golden, TheThreeApisAgreeOnTheGroom) { expectAgreement("groom", groomOn); }

TEST(Golden, TheSortedGroomOnVulkanLooksAsItDid) { expectSorted(Api::kVulkan); }
TEST(Golden, TheSortedGroomOnGlLooksAsItDid) { expectSorted(Api::kGl); }
TEST(Golden, TheSortedGroomOnGlesLooksAsItDid) { expectSorted(Api::kGles); }
TEST(Golden, TheThreeApisAgreeOnTheSortedGroom) { expectAgreement("sorted groom", sortedOn); }

TEST(Golden, TheCharacterOnVulkanLooksAsItDid) { expectCharacter(Api::kVulkan); }
TEST(Golden, TheCharacterOnGlLooksAsItDid) { expectCharacter(Api::kGl); }
TEST(Golden, TheCharacterOnGlesLooksAsItDid) { expectCharacter(Api::kGles); }
TEST(Golden, TheThreeApisAgreeOnTheCharacter) { expectAgreement("character", characterOn); }

TEST(Golden, TheThreeApisAgreeOnTheMohawk) {
  if (!std::filesystem::exists(ratboy("Ratboy_mohawk.tfx")))
    GTEST_SKIP() << "skipped: there is no " << ratboy("Ratboy_mohawk.tfx");
  expectAgreement("mohawk", mohawkOn);
}

TEST(Golden, TheMohawkLooksAsItDid) {
  if (!std::filesystem::exists(ratboy("Ratboy_mohawk.tfx")))
    GTEST_SKIP() << "skipped: there is no " << ratboy("Ratboy_mohawk.tfx");
  for (const Api api : kApis) {
    const Rendered& mohawk = mohawkOn(api);
    if (!mohawk.available) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << mohawk.why;
    for (const auto& [frame, picture] : mohawk.pictures)
      compareWithGolden("mohawk_" + std::to_string(frame), pelage::apiName(api), picture);
  }
}

// The tolerance would hide nothing: another time of the same motion is far outside of it.
TEST(Golden, TheToleranceTellsTwoFramesApart) {
  for (const Api api : kApis) {
    const Rendered& groom = groomOn(api);
    if (!groom.available) continue;
    const ImageDifference d =
        difference(groom.pictures.begin()->second, groom.pictures.rbegin()->second, kThreshold);
    EXPECT_GT(d.mean, 2 * kMeanTolerance);
    EXPECT_GT(d.shareOff, 2 * kShareTolerance);
    return;
  }
  PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no device";
}

}  // namespace
