// A device that is lost: the scene goes on with another one, from what the host has and from what
// was read back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "pelage/skeleton.h"
#include "support/plain_asset.h"
#include "support/required_devices.h"
#include "support/scene_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kPixels = 64;

bool sameBits(const std::vector<Float4>& a, const std::vector<Float4>& b) {
  return !a.empty() && a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(Float4)) == 0;
}

class Recovery : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  void SetUp() override {
    makeDevice();
    if (device_ == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    scene_.setTier(device_->info().tier);
    std::vector<FollowHair> follows;
    for (uint32_t i = 0; i < 8; ++i)
      follows.push_back({.guide = i, .offset = {0.004f, 0, 0.003f, 1.5f}});
    HairDef def = {.followHairs = follows};
    def.settings.solver = std::get<1>(GetParam());
    def.settings.contact.stiffness = def.settings.solver == Solver::kExact ? 0.3f : 0.0f;
    def.settings.wind.velocity = {0, 0, 0.5f};
    const auto added = scene_.addHair(makeAsset(20), def);
    ASSERT_TRUE(added);
    id_ = *added;
    hair().material.fiberRadius = 0.001f;
    hair().tracksMotion = true;
  }
  void TearDown() override {
    if (device_ != nullptr) {
      EXPECT_EQ(device_->messageCount(), 0u);
    }
  }
  void makeDevice() {
    auto made = createDevice({.api = std::get<0>(GetParam()), .validation = true});
    if (!made) made = createDevice({.api = std::get<0>(GetParam())});
    if (made) device_ = std::move(*made);
  }
  /// As after an error of kDeviceLost: nothing of the old device is of use.
  void loseDevice() {
    device_.reset();
    makeDevice();
    ASSERT_NE(device_, nullptr);
  }
  HairObject& hair() { return scene_.hair(id_); }
  BufferReader reader() {
    return [this](BufferId buffer) { return device_->read(buffer); };
  }
  void setInputs(int frame) {
    const float t = static_cast<float>(frame);
    const AffineTransform bone =
        rigidTransform({0, 0, std::sin(0.04f * t), std::cos(0.04f * t)}, {0.004f * t, 0, 0});
    hair().setBones({&bone, 1});
    const CapsuleCollider ball = {.head = {0.05f + 0.002f * t, 0.06f, 0},
                                  .headRadius = 0.02f,
                                  .tail = {0.15f, 0.06f, 0},
                                  .tailRadius = 0.02f};
    hair().setColliders({&ball, collides_ ? 1u : 0u});
  }
  void step(int frame) {
    setInputs(frame);
    auto made = scene_.simulate(1.0f / 60);
    ASSERT_TRUE(made) << made.error().message;
    expectOk(device_->run(*made));
  }
  /// Of a pause.
  std::vector<Float4> picture() {
    auto frame = scene_.simulate(0);
    EXPECT_TRUE(frame);
    View view;
    view.eye = {0.1f, 0.04f, 0.5f};
    view.worldToClip = lookAt(view.eye, {0.1f, 0.04f, 0}, {0, 1, 0}, 0.8f, 1, 0.05f, 5);
    view.width = view.height = kPixels;
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 32};
    EXPECT_TRUE(frame->draw(view, {&light, 1}));
    const RenderTargetDef target = {.width = kPixels, .height = kPixels};
    auto images = device_->render(*frame, {&target, 1});
    EXPECT_TRUE(images) << images.error().message;
    return images ? (*images)[0].pixels : std::vector<Float4>();
  }
  std::vector<Float4> positions() {
    const auto bytes = device_->read(hair().buffers().positions);
    EXPECT_TRUE(bytes) << bytes.error().message;
    std::vector<Float4> values(bytes ? bytes->size() / sizeof(Float4) : 0);
    if (bytes) std::memcpy(values.data(), bytes->data(), bytes->size());
    return values;
  }

  std::unique_ptr<HeadlessDevice> device_;
  Scene scene_;
  HairId id_ = {};
  bool collides_ = true;
};

TEST_P(Recovery, ThePictureIsTheOneBeforeAndHairGoesOn) {
  for (int frame = 0; frame < 8; ++frame) step(frame);
  const auto snapshot = scene_.takeSnapshot(reader());
  ASSERT_TRUE(snapshot) << snapshot.error().message;
  EXPECT_GT(snapshot->bytes(), 0u);
  const std::vector<Float4> before = picture();
  EXPECT_GT(std::ranges::count_if(before, [](const Float4& p) { return p.w > 0; }), 50);
  // What comes behind the snapshot is forgotten, and what does not run as well.
  std::vector<std::vector<Float4>> expected;
  for (int frame = 8; frame < 13; ++frame) {
    step(frame);
    expected.push_back(positions());
  }
  const double time = scene_.time();
  PassList lost;
  expectOk(scene_.simulate(1.0f / 60, lost));
  scene_.finish(lost);
  loseDevice();
  const auto kept = scene_.recover(*snapshot);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(*kept, 1u);
  // Shadow maps lie around the hair where its bones are.
  setInputs(7);
  EXPECT_TRUE(sameBits(picture(), before));
  for (int frame = 8; frame < 13; ++frame) {
    step(frame);
    EXPECT_TRUE(sameBits(positions(), expected[static_cast<size_t>(frame - 8)])) << frame;
  }
  EXPECT_EQ(scene_.time(), time);
}

// The world's origin is elsewhere than it was in the snapshot.
TEST_P(Recovery, AShiftOfTheOriginSinceReachesTheSnapshot) {
  for (int frame = 0; frame < 6; ++frame) step(frame);
  const auto snapshot = scene_.takeSnapshot(reader());
  ASSERT_TRUE(snapshot) << snapshot.error().message;
  const std::vector<Float4> before = positions();
  expectOk(scene_.shiftOrigin({3, -2, 5}));
  loseDevice();
  const auto kept = scene_.recover(*snapshot);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(*kept, 1u);
  auto frame = scene_.simulate(0);
  ASSERT_TRUE(frame);
  View view;
  view.eye = {-2.9f, 2.04f, -4.5f};
  view.worldToClip = lookAt(view.eye, {-2.9f, 2.04f, -5}, {0, 1, 0}, 0.8f, 1, 0.05f, 5);
  view.width = view.height = kPixels;
  const Light light;
  ASSERT_TRUE(frame->draw(view, {&light, 1}));
  const RenderTargetDef target = {.width = kPixels, .height = kPixels};
  const auto images = device_->render(*frame, {&target, 1});
  ASSERT_TRUE(images) << images.error().message;
  const std::vector<Float4>& pixels = (*images)[0].pixels;
  EXPECT_GT(std::ranges::count_if(pixels, [](const Float4& p) { return p.w > 0; }), 50);
  const std::vector<Float4> after = positions();
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    ASSERT_NEAR(after[i].x, before[i].x - 3, 2e-6) << i;
    ASSERT_NEAR(after[i].y, before[i].y + 2, 2e-6) << i;
    ASSERT_NEAR(after[i].z, before[i].z - 5, 2e-6) << i;
  }
}

TEST_P(Recovery, WithoutASnapshotHairBeginsAnew) {
  // One that jumps would push the hair.
  collides_ = false;
  step(0);
  const std::vector<Float4> first = positions();
  for (int frame = 1; frame < 6; ++frame) step(frame);
  loseDevice();
  const auto kept = scene_.recover();
  ASSERT_TRUE(kept);
  EXPECT_EQ(*kept, 0u);
  step(0);
  const std::vector<Float4> again = positions();
  ASSERT_EQ(again.size(), first.size());
  // The gusts go on.
  for (size_t i = 0; i < first.size(); ++i) {
    ASSERT_NEAR(again[i].x, first[i].x, 1e-3);
    ASSERT_NEAR(again[i].y, first[i].y, 1e-3);
    ASSERT_NEAR(again[i].z, first[i].z, 1e-3);
  }
  EXPECT_GT(std::ranges::count_if(picture(), [](const Float4& p) { return p.w > 0; }), 50);
}

TEST_P(Recovery, HairThatHasOtherBuffersByNowBeginsAnew) {
  for (int frame = 0; frame < 4; ++frame) step(frame);
  const auto snapshot = scene_.takeSnapshot(reader());
  ASSERT_TRUE(snapshot);
  hair().tracksMotion = false;
  step(4);
  step(5);
  loseDevice();
  const auto kept = scene_.recover(*snapshot);
  ASSERT_TRUE(kept);
  EXPECT_EQ(*kept, 0u);
  step(6);
  for (const Float4& p : positions()) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
}

TEST_P(Recovery, SaysWhatIsWrong) {
  const auto expectError = [](const auto& result, const char* text) {
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message.find(text), std::string::npos) << result.error().message;
  };
  step(0);
  PassList list;
  expectOk(scene_.simulate(1.0f / 60, list));
  expectError(scene_.takeSnapshot(reader()), "has not run yet");
  step(1);
  expectError(scene_.takeSnapshot([](BufferId) -> Result<std::vector<std::byte>> {
    return Error{ErrorCode::kDeviceLost, "gone"};
  }),
              "gone");
  expectError(scene_.takeSnapshot([&](BufferId buffer) -> Result<std::vector<std::byte>> {
    Result<std::vector<std::byte>> bytes = device_->read(buffer);
    if (bytes) bytes->pop_back();
    return bytes;
  }),
              "the reader gave");
  const auto snapshot = scene_.takeSnapshot(reader());
  ASSERT_TRUE(snapshot);
  Scene other;
  expectError(other.recover(*snapshot), "another scene");
}

std::string nameOf(const testing::TestParamInfo<std::tuple<Api, Solver>>& test) {
  return std::string(apiName(std::get<0>(test.param))) +
         (std::get<1>(test.param) == Solver::kExact ? "Exact" : "Classic");
}
INSTANTIATE_TEST_SUITE_P(All, Recovery, testing::ValuesIn(solversOnApis()), nameOf);

}  // namespace
}  // namespace pelage::test
