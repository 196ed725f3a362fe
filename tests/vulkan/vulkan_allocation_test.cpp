// Recording a frame that is like those before it calls operator new in no function of the library.
#include <gtest/gtest.h>

#include "support/steady_scene.h"
#include "vulkan/vulkan_target.h"

namespace pelage::test {
namespace {

class VulkanAllocation : public testing::TestWithParam<uint32_t>,
                         protected runtime_test::EngineRun {
 protected:
  void SetUp() override {
    VkPhysicalDeviceFeatures features = {};
    features.fragmentStoresAndAtomics = VK_TRUE;
    open(features, false);
  }
  void TearDown() override { close(); }
};
INSTANTIATE_TEST_SUITE_P(Objects, VulkanAllocation, testing::Values(1, 12));

TEST_P(VulkanAllocation, IsNotNeededByFramesThatAreAlike) {
  createRuntime(engine_->runtimeDef());
  Scene scene;
  scene.setTier(runtime_->tier());
  SteadyScene steady(scene, GetParam());
  const TargetKind kind = {.name = "plain", .dynamic = engine_->dynamicRendering()};
  const VulkanTarget target(*engine_, kind);
  constexpr Transparency kMethods[] = {Transparency::kTiles, Transparency::kWindowed};
  // Until each pass has had a descriptor set with each block of constants.
  constexpr int kWarmUp = 60;
  uint64_t passes = 0, taken = 0, engines = 0;
  for (int i = 0; i < kWarmUp + SteadyScene::kFrames; ++i) {
    ++frame_;
    const runtime_test::Engine::Frame& commands = frames_[frame_ % kFramesInFlight];
    engine_->begin(commands);
    if (i == 0) target.prepare(commands.commands);
    const vulkan::ViewTarget view = {
        .formats = target.formats(),
        .area = {{0, 0}, {VulkanTarget::kSize, VulkanTarget::kSize}},
        .begin =
            [&](const FrameStep& step) {
              const uint64_t before = g_newCount;
              target.begin(commands.commands, step.listOfView == 0);
              engines += g_newCount - before;
            },
        .end = [&](const FrameStep&) { target.end(commands.commands); }};
    const std::vector<vulkan::ViewTarget> targets(std::size(kMethods) + 1, view);
    steady.setInputs();
    engines = 0;
    const uint64_t before = g_newCount;
    runtime_->beginFrame(frame_, frame_ > kFramesInFlight ? frame_ - kFramesInFlight : 0);
    Frame frame = steady.makeFrame(kMethods, VulkanTarget::kSize);
    const Result<void> recorded = runtime_->record(frame, commands.commands, targets);
    const uint64_t count = g_newCount - before - engines;
    ASSERT_TRUE(recorded) << recorded.error().message;
    for (const FrameStep& step : frame.steps()) passes += step.list->passes.size();
    submit(commands);
    if (i >= kWarmUp) taken += count;
  }
  EXPECT_GT(passes, 0u);
  EXPECT_EQ(taken, 0u);
  waitForFrames();
}

}  // namespace
}  // namespace pelage::test
