// Golden images: the sample's scene at a small size against pictures in images/. A
// failing test writes what it saw, the difference and the golden into the build folder. After a
// change that is meant, run the test with PELAGE_UPDATE_GOLDEN=1 and look at the new pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "asset_files.h"
#include "demo_scene.h"
#include "device.h"
#include "image_difference.h"
#include "png_file.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"

namespace {

using pelage::Api;
using pelage::test::difference;
using pelage::test::ImageDifference;
using pelage::test::required;
using sample::ByteImage;

constexpr uint32_t kGoldenSize = 160;  // pixels
constexpr uint32_t kSamples = 4;
// Pixels differ by more than this where a strand covers one sample more on another rasteriser.
constexpr uint32_t kThreshold = 24;       // 1/255
constexpr double kMeanTolerance = 1.0;    // 1/255
constexpr double kShareTolerance = 0.02;  // of the pixels may be over the threshold

/// A picture of a run.
struct Shot {
  const char* name;  ///< of the golden image
  uint32_t frame;
  bool sorted;  ///< with sorted transparency and shadows: nothing in it is random
};

struct GoldenRun {
  pelage::Result<sample::DemoScene> (*makeScene)();
  std::vector<Shot> shots;  ///< by frame
};

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
  sample::DemoDef demo;
  demo.followPerGuide = 24;  // its fibers are thinner than a pixel
  return sample::DemoScene::create(sample::FileAssets{*files, {}}, demo);
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

/// Draws what has been simulated.
pelage::Result<ByteImage> draw(pelage::HeadlessDevice& device, sample::DemoScene& demo,
                               bool sorted) {
  demo.setShadow(sorted ? pelage::HairShadow::kDeep : pelage::HairShadow::kNone);
  pelage::TransparencySettings settings;
  settings.method = sorted ? pelage::Transparency::kWindowed : pelage::Transparency::kStochastic;
  settings.nodeCount = 1 << 20;
  pelage::RenderTargetDef target;
  target.width = target.height = kGoldenSize;
  target.samples = sorted ? 1 : kSamples;
  const pelage::View view =
      sample::makeView(demo.camera(1), kGoldenSize, kGoldenSize, target.samples);
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

using Pictures = std::map<std::string, ByteImage>;

pelage::Result<Pictures> render(pelage::HeadlessDevice& device, const GoldenRun& run) {
  auto demo = run.makeScene();
  if (!demo) return demo.error();
  demo->setTier(device.info().tier);
  Pictures pictures;
  pelage::PassList list;
  for (uint32_t frame = 1; frame <= run.shots.back().frame; ++frame) {
    list.clear();
    if (auto done = demo->advance(list); !done) return done.error();
    demo->finish(list);
    if (auto done = device.update(demo->resources()); !done) return done.error();
    if (auto done = device.execute(list); !done) return done.error();
    for (const Shot& shot : run.shots) {
      if (shot.frame != frame) continue;
      auto picture = draw(device, *demo, shot.sorted);
      if (!picture) return picture.error();
      pictures[shot.name] = std::move(*picture);
    }
  }
  return pictures;
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
    required(sample::writePng(goldenPath(name).string(), actual));
    return;
  }
  const auto golden = required(sample::readPng(goldenPath(name).string()));
  ASSERT_EQ(golden->width, actual.width);
  ASSERT_EQ(golden->height, actual.height);
  const ImageDifference d = difference(actual, *golden, kThreshold);
  std::cout << name << " on " << api << ": " << d << "\n";
  EXPECT_LE(d.mean, kMeanTolerance);
  EXPECT_LE(d.shareOff, kShareTolerance);
  if (d.mean > kMeanTolerance || d.shareOff > kShareTolerance)
    keepForInspection(name + "_" + api, actual, *golden);
}

class Golden : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    auto device = sample::createDevice({.api = GetParam(), .maxTier = pelage::test::tierOfTests()});
    if (!device) {
      ASSERT_EQ(device.error().code, pelage::ErrorCode::kUnsupported) << device.error().message;
      PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: " << device.error().message;
    }
    device_ = std::move(*device);
  }

  /// Renders a run and compares its pictures with the golden ones: so APIs are compared, too.
  Pictures expectGolden(const GoldenRun& run) {
    Pictures pictures = *required(render(*device_, run));
    for (const auto& [name, picture] : pictures)
      compareWithGolden(name, pelage::apiName(GetParam()), picture);
    return pictures;
  }

  std::unique_ptr<pelage::HeadlessDevice> device_;
};
INSTANTIATE_TEST_SUITE_P(All, Golden, testing::ValuesIn(pelage::test::kRuntimeApis),
                         pelage::test::apiTestName);

// At rest, and in the swing to one side.
TEST_P(Golden, TheGroomLooksAsItDid) {
  const Pictures pictures = expectGolden(
      {groomScene, {{"groom_10", 10, false}, {"groom_45", 45, false}, {"sorted_45", 45, true}}});
  // The tolerance hides nothing: another time of the same motion is far outside of it.
  const ImageDifference d =
      difference(pictures.at("groom_10"), pictures.at("groom_45"), kThreshold);
  EXPECT_GT(d.mean, 2 * kMeanTolerance);
  EXPECT_GT(d.shareOff, 2 * kShareTolerance);
}

/// On the first API: what runs is the groom's, and the samples draw the character on every one.
class GoldenOnce : public Golden {};
INSTANTIATE_TEST_SUITE_P(All, GoldenOnce, testing::Values(pelage::test::kFirstApi),
                         pelage::test::apiTestName);

// While it shakes its head; long hair flies.
TEST_P(GoldenOnce, TheCharacterLooksAsItDid) {
  expectGolden({characterScene, {{"character_20", 20, true}}});
}

TEST_P(GoldenOnce, TheMohawkLooksAsItDid) {
  if (!std::filesystem::exists(ratboy("Ratboy_mohawk.tfx")))
    GTEST_SKIP() << "skipped: there is no " << ratboy("Ratboy_mohawk.tfx");
  expectGolden({mohawkScene, {{"mohawk_45", 45, false}}});
}

}  // namespace
