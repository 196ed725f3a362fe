// The classic baseline of the transparency benchmark draws what is known of the original, and the
// benchmark measures what it says. K numbers are those of the list of defects that this library
// must not have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include "device.h"
#include "oit/oit_measure.h"
#include "simulation/bench_device.h"
#include "support/required_devices.h"
#include "support/test_folder.h"

namespace bench {
namespace {

using pelage::Api;
using pelage::HeadlessDevice;
using pelage::Result;
using pelage::test::TestFolder;
using pelage::test::textOf;

constexpr uint32_t kPixels = 72;

const OitMethod& methodNamed(const std::string& name) {
  const auto methods = oitMethods();
  const auto found = std::find_if(methods.begin(), methods.end(),
                                  [&](const OitMethod& method) { return method.name == name; });
  EXPECT_TRUE(found != methods.end()) << name;
  return *found;
}

class OitBaseline : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    pelage::HeadlessDef deviceDef;
    deviceDef.api = GetParam();
    auto device = bench::createDevice(deviceDef);
    if (!device && device.error().code == pelage::ErrorCode::kUnsupported)
      PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
    ASSERT_TRUE(device.ok()) << device.error().message;
    device_ = std::move(*device);
    auto def = groomScene(150, 1);
    ASSERT_TRUE(def.ok()) << def.error().message;
    // As many layers as the mohawk has, of fibers that are wider than a pixel.
    def->material.fiberRadius = 1.2e-3f;
    def->material.opacity = 0.33f;
    def->light.shadow = pelage::HairShadow::kNone;
    auto scene = HairScene::create(*def, *device_);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    scene_ = std::move(*scene);
    copies_ = std::make_unique<CopyReference>(*device_, scene_->scene(), kOnce);
    view_ = sample::makeView(def->whole, kPixels, kPixels, 1);
  }

  ExactPicture exact(uint32_t limit = 1 << 20) {
    auto picture = FragmentReference(*scene_, limit).picture(view_);
    EXPECT_TRUE(picture.ok()) << (picture.ok() ? "" : picture.error().message);
    return picture.ok() ? std::move(*picture) : ExactPicture{};
  }

  OitRow measured(const std::string& method, const ExactPicture& picture) {
    OitRow row;
    const Result<void> done = measureOit({*scene_, *copies_, view_, picture}, methodNamed(method),
                                         {.frames = 1, .together = 2}, row);
    EXPECT_TRUE(done.ok()) << (done.ok() ? "" : done.error().message);
    return row;
  }

  // Every other row or so is judged like all of them.
  void expectRowsLikeAll() {
    const ExactPicture all = exact();
    const auto limit = static_cast<uint32_t>(all.fragments / 2);
    const ExactPicture some = exact(limit);
    EXPECT_EQ(all.rowStep, 1u);
    EXPECT_GT(some.rowStep, 1u);
    EXPECT_EQ(some.fragments, all.fragments);
    EXPECT_NEAR(some.layersMean, all.layersMean, 0.2 * all.layersMean);
    for (const ExactPicture::Pixel& pixel : some.pixels)
      ASSERT_EQ(pixel.index / kPixels % some.rowStep, 0u);
    // Each of them is in both, and the same.
    size_t found = 0;
    for (const ExactPicture::Pixel& pixel : all.pixels) {
      if (found == some.pixels.size() || some.pixels[found].index != pixel.index) continue;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(some.pixels[found].color[c], pixel.color[c], 1e-6);
      ++found;
    }
    EXPECT_EQ(found, some.pixels.size());
  }

  std::unique_ptr<HeadlessDevice> device_;
  std::unique_ptr<HairScene> scene_;
  std::unique_ptr<CopyReference> copies_;
  pelage::View view_;
};

// K36 and K37: 39.8 to 44.9 dB.
TEST_P(OitBaseline, ClassicIsNearTheExactCompositeAndWindowedIsNearer) {
  const ExactPicture picture = exact();
  EXPECT_GT(picture.layersMean, 15);
  EXPECT_LT(picture.layersMean, 60);
  const OitRow classic = measured("classic8", picture);
  EXPECT_GE(classic.error.psnr, 36);
  EXPECT_LE(classic.error.psnr, 46);
  EXPECT_GT(classic.error.off, 0.2);
  const OitRow windowed = measured("windowed", picture);
  EXPECT_GE(windowed.error.psnr, 64);
  EXPECT_EQ(windowed.error.off, 0);
  std::cout << pelage::apiName(GetParam()) << ": " << picture.layersMean << " layers, classic "
            << classic.error.psnr << " dB, " << 100 * classic.error.off << " % off, windowed "
            << windowed.error.psnr << " dB\n";
  // 16 bytes a node with a sixteenth to spare, and 4 a pixel.
  EXPECT_NEAR(static_cast<double>(classic.bytes),
              16.0 * static_cast<double>(picture.fragments) * 17 / 16 + 4 * kPixels * kPixels, 64);

  // K35: a pool that is full empties pixels.
  ClassicList tight(*scene_);
  std::vector<pelage::PassList> lists;
  const Result<void> drawn = tight.draw(
      view_, static_cast<uint32_t>(0.95 * static_cast<double>(picture.fragments)), lists);
  ASSERT_TRUE(drawn.ok()) << drawn.error().message;
  const auto image = scene_->render(lists, view_, pelage::BufferId::kInvalid, nullptr);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_LT(comparePicture(*image, picture).psnr, classic.error.psnr - 10);
}

TEST_P(OitBaseline, HasFiguresOfMethodsWithoutListsAndWritesTheHeaderOnce) {
  expectRowsLikeAll();
  const ExactPicture picture = exact();
  const TestFolder folder;
  const std::string path = (folder / "figures.csv").string();
  for (const char* name : {"hybrid4", "stochastic"}) {
    OitRow row = measured(name, picture);
    EXPECT_GT(row.error.psnr, 10) << name;
    EXPECT_LT(row.error.psnr, 40) << name;
    // A method without timestamps has none, and no time is taken for 0.
    EXPECT_TRUE(row.total < 0 || row.resolve > 0) << name;
    EXPECT_EQ(row.bytes > 0, std::string(name) == "hybrid4");
    row.scene = "groom";
    const Result<void> done = appendOitCsv(path, row, device_->info(), "test");
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  const std::string text = textOf(path);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_EQ(text.find("commit,api,"), 0u);
  EXPECT_EQ(text.find("commit,api,", 1), std::string::npos);
  // As many fields in front of the device, which is quoted, as the header has.
  const auto commasTo = [&](size_t from, size_t end) {
    return std::count(text.begin() + static_cast<ptrdiff_t>(from),
                      text.begin() + static_cast<ptrdiff_t>(end), ',');
  };
  EXPECT_EQ(commasTo(0, text.find(",device")), commasTo(text.find('\n'), text.find(",\"")));
}

INSTANTIATE_TEST_SUITE_P(Api, OitBaseline, testing::Values(Api::kVulkan, Api::kGl),
                         [](const testing::TestParamInfo<Api>& test) {
                           return std::string(pelage::apiName(test.param));
                         });

}  // namespace
}  // namespace bench
