// Frames of a Vulkan engine that are not submitted: as if they had never been written.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineRun;

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

class VulkanDelivery : public testing::TestWithParam<Solver>, protected EngineRun {
 protected:
  using Results = DeliveryScene::Results;

  void SetUp() override {
    open();
    if (engine_ != nullptr) createRuntime(engine_->runtimeDef());
  }
  void TearDown() override { close(); }
  void write(DeliveryScene& scene, int frame, PassList& list) {
    expectOk(scene.simulate(frame, list));
    scene_.finish(list);
  }

  void lose(DeliveryScene& scene, int frame, Loss loss) {
    const Engine::Frame& slot = beginFrame();
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
    // A list after one that will not run: refused, and lost as well.
    write(scene, frame, other_);
    const Engine::Frame& next = beginFrame();
    expectOk(runtime_->update(scene_.resources(), next.commands));
    EXPECT_FALSE(runtime_->record(other_, next.commands));
    submit(next);
  }
  // As an object, in one call.
  void record(DeliveryScene& scene, int frame, const Engine::Frame& slot) {
    Frame made = scene.makeFrame(frame);
    expectOk(runtime_->record(made, slot.commands));
    EXPECT_EQ(scene.results().back(), scene_.shadowWords());
  }
  void execute(DeliveryScene& scene, int frame) {
    const Engine::Frame& slot = beginFrame();
    if (frames_) {
      record(scene, frame, slot);
      return submit(slot);
    }
    write(scene, frame, list_);
    expectOk(runtime_->update(scene_.resources(), slot.commands));
    expectOk(runtime_->record(list_, slot.commands));
    // Written again before it is submitted: the runtime knows it all the same.
    list_.clear();
    submit(slot);
  }
  Results readAll(const DeliveryScene& scene) const {
    return scene.readResults([this](BufferId buffer) { return read(buffer); });
  }
  std::vector<Results> play(Loss loss) {
    DeliveryScene scene(scene_, GetParam());
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      scene.setInputs(frame);
      if (loss != Loss::kNone) lose(scene, frame, loss);
      execute(scene, frame);
      waitForFrames();
      frames.push_back(readAll(scene));
    }
    scene.remove();
    return frames;
  }

  Scene scene_;
  PassList list_, other_;
  bool frames_ = false;  // objects in place of lists
};

TEST_P(VulkanDelivery, MakesNoPipelineThatWasNotPrepared) {
  const Result<PassList> list = required(listToPrepare(DeliveryScene::features(GetParam())));
  expectOk(runtime_->prepare(*list));
  const size_t prepared = runtime_->pipelineTimes().size();
  EXPECT_EQ(prepared, list->passes.size());
  DeliveryScene scene(scene_, GetParam());
  frames_ = true;
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    scene.setInputs(frame);
    execute(scene, frame);
    waitForFrames();
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

// An engine that forgets submitted() sees it at once, and loses nothing.
TEST_P(VulkanDelivery, WithoutSubmittedHairStaysInItsBindShape) {
  DeliveryScene scene(scene_, GetParam());
  std::vector<std::byte> first;
  for (int frame = 0; frame < 3; ++frame) {
    scene.setInputs(0);
    const Engine::Frame& slot = beginFrame();
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
  Result<Frame> frame = required(scene_.simulate(1.0f / 60));
  ASSERT_TRUE(frame->addView({}));
  const Engine::Frame& slot = beginFrame();
  expectError(runtime_->record(*frame, slot.commands), "1 views, but there are 0 targets");
  // The render pass of the view is begun and ended, also where it has nothing to draw.
  std::string calls;
  vulkan::ViewTarget target;
  target.begin = [&](const FrameStep& step) { calls += "begin" + std::to_string(step.listOfView); };
  target.end = [&](const FrameStep&) { calls += " end"; };
  target.area.extent = {8, 8};
  expectOk(runtime_->record(*frame, slot.commands, {&target, 1}));
  EXPECT_EQ(calls, "begin0 end");
  submit(slot);
}

// Two frames of a scene in one submission count together.
TEST_P(VulkanDelivery, SeveralFramesMayBeInOneSubmission) {
  const std::vector<Results> apart = play(Loss::kNone);
  DeliveryScene scene(scene_, GetParam());
  for (int frame = 0; frame < DeliveryScene::kFrames; frame += 2) {
    const Engine::Frame& slot = beginFrame();
    for (const int part : {frame, frame + 1}) {
      scene.setInputs(part);
      write(scene, part, list_);
      expectOk(runtime_->update(scene_.resources(), slot.commands));
      expectOk(runtime_->record(list_, slot.commands));
    }
    submit(slot);
    engine_->wait(slot);
    const Results seen = readAll(scene);
    for (size_t i = 0; i < seen.size(); ++i) {
      ASSERT_TRUE(seen[i] == apart[static_cast<size_t>(frame) + 1][i])
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
