// A device that is lost: the scene goes on with another one, from what the host has and from what
// was read back. All of it is the host's code: to a runtime, the other device is a new one.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <tuple>
#include <vector>

#include "pelage/skeleton.h"
#include "support/errors.h"
#include "support/pictures.h"
#include "support/plain_asset.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

constexpr uint32_t kRecoveryPixels = 64;

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
    const auto added = required(scene_.addHair(makeAsset(20), def));
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
    auto made = required(scene_.simulate(1.0f / 60));
    expectOk(device_->run(*made));
  }
  /// Draws a frame of 0 s.
  std::vector<Float4> picture(Float3 origin = {}) {
    auto frame = scene_.simulate(0);
    EXPECT_TRUE(frame);
    const View view = cameraView({.eye = {0.1f + origin.x, 0.04f + origin.y, 0.5f + origin.z},
                                  .target = {0.1f + origin.x, 0.04f + origin.y, origin.z},
                                  .fov = 0.8f,
                                  .width = kRecoveryPixels});
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 32};
    EXPECT_TRUE(frame->draw(view, {&light, 1}));
    const RenderTargetDef target = {.width = kRecoveryPixels, .height = kRecoveryPixels};
    auto images = device_->render(*frame, {&target, 1});
    EXPECT_TRUE(images) << images.error().message;
    return images ? (*images)[0].pixels : std::vector<Float4>();
  }
  std::vector<Float4> positions() {
    const std::vector<std::byte> bytes = valueOf(device_->read(hair().buffers().positions));
    std::vector<Float4> values(bytes.size() / sizeof(Float4));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }

  std::unique_ptr<HeadlessDevice> device_;
  Scene scene_;
  HairId id_ = {};
  bool collides_ = true;
};

TEST_P(Recovery, ThePictureIsTheOneBeforeAndHairGoesOn) {
  for (int frame = 0; frame < 8; ++frame) step(frame);
  const auto snapshot = required(scene_.takeSnapshot(reader()));
  EXPECT_GT(snapshot->bytes(), 0u);
  const std::vector<Float4> before = picture();
  EXPECT_GT(coveredPixels(before), 50u);
  // Going back forgets frames after the snapshot, and frames that do not run as well.
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
  const auto kept = required(scene_.recover(*snapshot));
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
  const auto snapshot = required(scene_.takeSnapshot(reader()));
  const std::vector<Float4> before = positions();
  expectOk(scene_.shiftOrigin({3, -2, 5}));
  loseDevice();
  const auto kept = required(scene_.recover(*snapshot));
  EXPECT_EQ(*kept, 1u);
  EXPECT_GT(coveredPixels(picture({-3, 2, -5})), 50u);
  const std::vector<Float4> after = positions();
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) {
    ASSERT_NEAR(after[i].x, before[i].x - 3, 2e-6) << i;
    ASSERT_NEAR(after[i].y, before[i].y + 2, 2e-6) << i;
    ASSERT_NEAR(after[i].z, before[i].z - 5, 2e-6) << i;
  }
}

TEST_P(Recovery, WithoutASnapshotHairBeginsAnew) {
  // A collider that jumps would push the hair.
  collides_ = false;
  step(0);
  const std::vector<Float4> first = positions();
  for (int frame = 1; frame < 6; ++frame) step(frame);
  loseDevice();
  const auto kept = required(scene_.recover());
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
  EXPECT_GT(coveredPixels(picture()), 50u);
}

TEST_P(Recovery, HairThatHasOtherBuffersByNowBeginsAnew) {
  for (int frame = 0; frame < 4; ++frame) step(frame);
  const auto snapshot = required(scene_.takeSnapshot(reader()));
  hair().tracksMotion = false;
  step(4);
  step(5);
  loseDevice();
  const auto kept = required(scene_.recover(*snapshot));
  EXPECT_EQ(*kept, 0u);
  step(6);
  for (const Float4& p : positions()) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
}

TEST_P(Recovery, SaysWhatIsWrong) {
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
  const auto snapshot = required(scene_.takeSnapshot(reader()));
  Scene other;
  expectError(other.recover(*snapshot), "another scene");
}

INSTANTIATE_TEST_SUITE_P(All, Recovery,
                         testing::Combine(testing::Values(kFirstApi),
                                          testing::Values(Solver::kExact, Solver::kClassic)),
                         solverTestName);

}  // namespace
}  // namespace pelage::test
