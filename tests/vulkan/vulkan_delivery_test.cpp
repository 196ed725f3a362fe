// Frames of a Vulkan engine that are not submitted: as if they had never been written.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "support/delivery_scene.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;
using vulkan::Runtime;

enum class Loss {
  kNone,
  kUpdate,       ///< update() alone is recorded
  kPrepare,      ///< the list is only prepared
  kSubmission,   ///< everything is recorded
  kTold,         ///< and the runtime is told
  kAheadOfTime,  ///< simulate() comes before beginFrame() of the frame behind the lost one
  kRefused,      ///< record() refuses the list, update() is submitted
  kTwoLists,     ///< two frames of the scene in one submission
  kFrame,        ///< a Frame is recorded
};

class VulkanDelivery : public testing::TestWithParam<Solver> {
 protected:
  using Results = std::vector<std::vector<std::byte>>;

  void SetUp() override {
    std::string reason;
    engine_ = Engine::create(reason);
    if (engine_ == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << reason;
    for (Engine::Frame& slot : slots_) slot = engine_->createFrame();
    copies_ = engine_->createFrame();
    Result<Runtime> made = Runtime::create(engine_->runtimeDef());
    ASSERT_TRUE(made) << made.error().message;
    runtime_.emplace(*std::move(made));
  }
  void TearDown() override {
    if (engine_ == nullptr) return;
    for (const Engine::Frame& slot : slots_) engine_->destroyFrame(slot);
    engine_->destroyFrame(copies_);
    runtime_.reset();
    EXPECT_EQ(engine_->messageCount(), 0u);
  }
  const Engine::Frame& begin() {
    ++frame_;
    const Engine::Frame& slot = slots_[frame_ % slots_.size()];
    engine_->begin(slot);
    runtime_->beginFrame(frame_, frame_ > slots_.size() ? frame_ - slots_.size() : 0);
    return slot;
  }
  void write(DeliveryScene& scene, int frame, PassList& list) {
    expectOk(scene.simulate(frame, list));
    scene_.finish(list);
  }
  void submit(const Engine::Frame& slot) {
    engine_->submit(slot);
    runtime_->submitted();
  }

  void lose(DeliveryScene& scene, int frame, Loss loss) {
    const Engine::Frame& slot = begin();
    if (loss == Loss::kFrame) {
      record(scene, frame, slot);
      engine_->discard(slot);
      return;
    }
    write(scene, frame, list_);
    if (loss == Loss::kPrepare) expectOk(runtime_->prepare(list_));
    if (loss != Loss::kPrepare) expectOk(runtime_->update(scene_.resources(), slot.commands));
    if (loss == Loss::kRefused) {
      list_.passes[0].groups[0] = 0;
      list_.passes[0].kind = PassKind::kDispatch;
      EXPECT_FALSE(runtime_->record(list_, slot.commands));
      return submit(slot);
    }
    if (loss == Loss::kTwoLists) {
      expectOk(runtime_->record(list_, slot.commands));
      write(scene, frame, other_);
      expectOk(runtime_->update(scene_.resources(), slot.commands));
      expectOk(runtime_->record(other_, slot.commands));
    }
    if (loss == Loss::kSubmission || loss == Loss::kTold || loss == Loss::kAheadOfTime)
      expectOk(runtime_->record(list_, slot.commands));
    engine_->discard(slot);
    if (loss == Loss::kTold) runtime_->abandonFrame();
    if (loss != Loss::kAheadOfTime) return;
    // On top of what will not run: refused, and lost as well.
    write(scene, frame, other_);
    const Engine::Frame& next = begin();
    expectOk(runtime_->update(scene_.resources(), next.commands));
    EXPECT_FALSE(runtime_->record(other_, next.commands));
    submit(next);
  }
  // As an object, in one call.
  void record(const DeliveryScene& scene, int frame, const Engine::Frame& slot) {
    Result<Frame> made = scene_.simulate(DeliveryScene::seconds(frame));
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_TRUE(made->interpolate(DeliveryScene::kShare));
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
    EXPECT_TRUE(made->castShadows({&light, 1}));
    const Result<void> recorded = runtime_->record(*made, slot.commands);
    EXPECT_TRUE(recorded) << recorded.error().message;
    EXPECT_EQ(scene.results().back(), scene_.shadowWords());
  }
  void execute(DeliveryScene& scene, int frame) {
    const Engine::Frame& slot = begin();
    if (frames_) {
      record(scene, frame, slot);
      return submit(slot);
    }
    write(scene, frame, list_);
    expectOk(runtime_->update(scene_.resources(), slot.commands));
    const Result<void> recorded = runtime_->record(list_, slot.commands);
    ASSERT_TRUE(recorded) << recorded.error().message;
    // Written again before it is submitted: the runtime knows it all the same.
    list_.clear();
    submit(slot);
  }
  std::vector<std::byte> read(BufferId id) {
    const vulkan::BufferRange range = runtime_->buffer(id);
    const EngineBuffer out =
        engine_->createBuffer(range.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    engine_->begin(copies_);
    VkMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    vkCmdPipelineBarrier(copies_.commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    const VkBufferCopy copy = {range.offset, 0, range.size};
    vkCmdCopyBuffer(copies_.commands, range.buffer, out.buffer, 1, &copy);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(copies_.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    engine_->submit(copies_);
    engine_->wait(copies_);
    std::vector<std::byte> bytes(range.size);
    std::memcpy(bytes.data(), out.mapped, bytes.size());
    engine_->destroyBuffer(out);
    return bytes;
  }
  std::vector<Results> play(Loss loss) {
    DeliveryScene scene(scene_, GetParam());
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      scene.setInputs(frame);
      if (loss != Loss::kNone) lose(scene, frame, loss);
      execute(scene, frame);
      for (const Engine::Frame& slot : slots_) engine_->wait(slot);
      Results results;
      for (const BufferId buffer : scene.results()) results.push_back(read(buffer));
      frames.push_back(std::move(results));
    }
    scene.remove();
    return frames;
  }

  std::unique_ptr<Engine> engine_;
  std::array<Engine::Frame, 3> slots_;
  Engine::Frame copies_;
  std::optional<Runtime> runtime_;
  Scene scene_;
  PassList list_, other_;
  uint64_t frame_ = 0;
  bool frames_ = false;  // objects in place of lists
};

TEST_P(VulkanDelivery, MakesNoPipelineThatWasNotPrepared) {
  const Result<PassList> list = listToPrepare(DeliveryScene::features(GetParam()));
  ASSERT_TRUE(list) << list.error().message;
  expectOk(runtime_->prepare(*list));
  const size_t prepared = runtime_->pipelineTimes().size();
  EXPECT_EQ(prepared, list->passes.size());
  DeliveryScene scene(scene_, GetParam());
  frames_ = true;
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    scene.setInputs(frame);
    execute(scene, frame);
    for (const Engine::Frame& slot : slots_) engine_->wait(slot);
    const std::vector<PipelineTime> times = runtime_->pipelineTimes();
    ASSERT_EQ(times.size(), prepared) << frame << ": " << times.back().name;
  }
}

TEST_P(VulkanDelivery, AFrameThatIsNotSubmittedIsAsIfItHadNeverBeenWritten) {
  const std::vector<Results> undisturbed = play(Loss::kNone);
  ASSERT_FALSE(HasFailure());
  ASSERT_NE(undisturbed[2][0], undisturbed[9][0]) << "it moved at all";
  for (const Loss loss : {Loss::kUpdate, Loss::kPrepare, Loss::kSubmission, Loss::kTold,
                          Loss::kAheadOfTime, Loss::kRefused, Loss::kTwoLists, Loss::kFrame}) {
    SCOPED_TRACE("loss " + std::to_string(static_cast<int>(loss)));
    frames_ = loss == Loss::kFrame;
    const std::vector<Results> frames = play(loss);
    ASSERT_FALSE(HasFailure());
    for (size_t frame = 0; frame < frames.size(); ++frame)
      for (size_t i = 0; i < frames[frame].size(); ++i)
        ASSERT_TRUE(frames[frame][i] == undisturbed[frame][i])
            << "frame " << frame << ", buffer " << i;
  }
}

// Whoever forgets it sees it at once, and loses nothing.
TEST_P(VulkanDelivery, WithoutSubmittedHairStaysInItsBindShape) {
  DeliveryScene scene(scene_, GetParam());
  std::vector<std::byte> first;
  for (int frame = 0; frame < 3; ++frame) {
    scene.setInputs(0);
    const Engine::Frame& slot = begin();
    write(scene, 0, list_);
    expectOk(runtime_->update(scene_.resources(), slot.commands));
    expectOk(runtime_->record(list_, slot.commands));
    engine_->submit(slot);
    engine_->wait(slot);
    const std::vector<std::byte> now = read(scene.results()[0]);
    if (frame == 0) first = now;
    EXPECT_EQ(now, first);
    EXPECT_EQ(scene_.time(), static_cast<double>(DeliveryScene::seconds(0)))
        << "not yet taken back";
  }
}

TEST_P(VulkanDelivery, AFrameHasATargetForEachView) {
  DeliveryScene scene(scene_, GetParam());
  Result<Frame> frame = scene_.simulate(1.0f / 60);
  ASSERT_TRUE(frame);
  ASSERT_TRUE(frame->addView({}));
  const Engine::Frame& slot = begin();
  const Result<void> recorded = runtime_->record(*frame, slot.commands);
  ASSERT_FALSE(recorded);
  EXPECT_NE(recorded.error().message.find("1 views, but there are 0 targets"), std::string::npos)
      << recorded.error().message;
  // The render pass of the view is begun and ended, also where it has nothing to draw.
  std::string calls;
  vulkan::ViewTarget target;
  target.begin = [&](const FrameStep& step) { calls += "begin" + std::to_string(step.listOfView); };
  target.end = [&](const FrameStep&) { calls += " end"; };
  target.area.extent = {8, 8};
  const Result<void> done = runtime_->record(*frame, slot.commands, {&target, 1});
  EXPECT_TRUE(done) << done.error().message;
  EXPECT_EQ(calls, "begin0 end");
  submit(slot);
}

// Two frames of a scene in one submission count together.
TEST_P(VulkanDelivery, SeveralFramesMayBeInOneSubmission) {
  const std::vector<Results> apart = play(Loss::kNone);
  DeliveryScene scene(scene_, GetParam());
  for (int frame = 0; frame < DeliveryScene::kFrames; frame += 2) {
    const Engine::Frame& slot = begin();
    for (const int part : {frame, frame + 1}) {
      scene.setInputs(part);
      write(scene, part, list_);
      expectOk(runtime_->update(scene_.resources(), slot.commands));
      expectOk(runtime_->record(list_, slot.commands));
    }
    submit(slot);
    engine_->wait(slot);
    for (size_t i = 0; i < scene.results().size(); ++i) {
      ASSERT_TRUE(read(scene.results()[i]) == apart[static_cast<size_t>(frame) + 1][i])
          << "frame " << frame << ", buffer " << i;
    }
  }
  scene.remove();
}

INSTANTIATE_TEST_SUITE_P(All, VulkanDelivery, testing::Values(Solver::kExact, Solver::kClassic),
                         [](const auto& tested) {
                           return tested.param == Solver::kExact ? "Exact" : "Classic";
                         });

}  // namespace
}  // namespace pelage::test
