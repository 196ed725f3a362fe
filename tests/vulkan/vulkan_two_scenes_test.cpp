// Two scenes on one Vulkan device, with a runtime each: frame by frame in turn, and in one
// submission, each has the bits that it has alone.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineRun;

using Results = DeliveryScene::Results;

// A scene with a runtime of its own; the command buffers are the test's.
class Player {
 public:
  Player(const Engine& engine, Solver solver) : engine_(engine), inputs_(scene_, solver) {
    Result<vulkan::Runtime> made = vulkan::Runtime::create(engine.runtimeDef());
    EXPECT_TRUE(made) << made.error().message;
    runtime_.emplace(*std::move(made));
  }
  // Earlier commands have finished on the device.
  void record(int frame, VkCommandBuffer commands) {
    runtime_->beginFrame(static_cast<uint64_t>(frame) + 1, static_cast<uint64_t>(frame));
    inputs_.setInputs(frame);
    Frame made = inputs_.makeFrame(frame);
    expectOk(runtime_->record(made, commands));
  }
  void submitted() { runtime_->submitted(); }
  Results read(const Engine::Frame& copies) {
    return inputs_.readResults(
        [&](BufferId buffer) { return engine_.read(runtime_->buffer(buffer), copies); });
  }
  Scene& scene() { return scene_; }
  vulkan::Runtime& runtime() { return *runtime_; }

 private:
  const Engine& engine_;
  Scene scene_;
  DeliveryScene inputs_;
  std::optional<vulkan::Runtime> runtime_;
};

class VulkanTwoScenes : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override { open(); }
  void TearDown() override { close(); }
  // Frames of all players, in one command buffer.
  std::vector<std::vector<Results>> play(std::initializer_list<Solver> solvers) {
    std::vector<std::unique_ptr<Player>> players;
    for (const Solver solver : solvers)
      players.push_back(std::make_unique<Player>(*engine_, solver));
    std::vector<std::vector<Results>> all(players.size());
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      engine_->begin(frames_[0]);
      for (const auto& player : players) player->record(frame, frames_[0].commands);
      engine_->submit(frames_[0]);
      for (const auto& player : players) player->submitted();
      engine_->wait(frames_[0]);
      for (size_t i = 0; i < players.size(); ++i) all[i].push_back(players[i]->read(copies_));
    }
    return all;
  }
};

TEST_F(VulkanTwoScenes, OnOneDeviceHaveTheBitsOfEachAlone) {
  const auto exact = play({Solver::kExact}), classic = play({Solver::kClassic});
  ASSERT_NE(exact[0][2][0], exact[0][9][0]) << "it moved at all";
  const auto both = play({Solver::kExact, Solver::kClassic});
  EXPECT_EQ(both[0], exact[0]);
  EXPECT_EQ(both[1], classic[0]);
}

TEST_F(VulkanTwoScenes, DoNotShareARuntime) {
  Player one(*engine_, Solver::kExact), other(*engine_, Solver::kExact);
  engine_->begin(frames_[0]);
  one.record(0, frames_[0].commands);
  expectError(one.runtime().update(other.scene().resources(), frames_[0].commands),
              "another ResourceTable");
  Result<Frame> frame = required(other.scene().simulate(0));
  EXPECT_FALSE(one.runtime().record(*frame, frames_[0].commands));
  engine_->submit(frames_[0]);
  one.submitted();
  engine_->wait(frames_[0]);
}

TEST_F(VulkanTwoScenes, FramesOfOneSceneDoNotGoToAnotherRuntime) {
  Player one(*engine_, Solver::kExact);
  engine_->begin(frames_[0]);
  one.record(0, frames_[0].commands);
  engine_->submit(frames_[0]);
  one.submitted();
  engine_->wait(frames_[0]);
  Result<vulkan::Runtime> other = required(vulkan::Runtime::create(engine_->runtimeDef()));
  engine_->begin(frames_[0]);
  other->beginFrame(1, 0);
  Result<Frame> frame = required(one.scene().simulate(1.0f / 60));
  expectError(other->record(*frame, frames_[0].commands), {"another runtime", "Scene::recover()"});
  ASSERT_TRUE(one.scene().recover());
  frame = required(one.scene().simulate(1.0f / 60));
  expectOk(other->record(*frame, frames_[0].commands));
  engine_->submit(frames_[0]);
  other->submitted();
  engine_->wait(frames_[0]);
}

}  // namespace
}  // namespace pelage::test
