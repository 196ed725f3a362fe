// Two scenes on one Vulkan device, with a runtime each: frame by frame in turn, and in one
// submission, each has the bits that it has alone.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/delivery_scene.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;

using Results = std::vector<std::vector<std::byte>>;

// A scene with a runtime of its own; the command buffers are the test's.
class Player {
 public:
  Player(const Engine& engine, Solver solver) : engine_(engine), inputs_(scene_, solver) {
    Result<vulkan::Runtime> made = vulkan::Runtime::create(engine.runtimeDef());
    EXPECT_TRUE(made) << made.error().message;
    runtime_.emplace(*std::move(made));
  }
  // What was recorded before has finished on the device.
  void record(int frame, VkCommandBuffer commands) {
    runtime_->beginFrame(static_cast<uint64_t>(frame) + 1, static_cast<uint64_t>(frame));
    inputs_.setInputs(frame);
    Result<Frame> made = scene_.simulate(DeliveryScene::seconds(frame));
    ASSERT_TRUE(made) << made.error().message;
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
    EXPECT_TRUE(made->castShadows({&light, 1}));
    expectOk(runtime_->record(*made, commands));
  }
  void submitted() { runtime_->submitted(); }
  Results read(const Engine::Frame& copies) {
    Results all;
    for (const BufferId buffer : inputs_.results()) all.push_back(read(buffer, copies));
    return all;
  }
  Scene& scene() { return scene_; }
  vulkan::Runtime& runtime() { return *runtime_; }

 private:
  std::vector<std::byte> read(BufferId id, const Engine::Frame& copies) {
    const vulkan::BufferRange range = runtime_->buffer(id);
    const EngineBuffer out =
        engine_.createBuffer(range.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
    engine_.begin(copies);
    VkMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    vkCmdPipelineBarrier(copies.commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    const VkBufferCopy copy = {range.offset, 0, range.size};
    vkCmdCopyBuffer(copies.commands, range.buffer, out.buffer, 1, &copy);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(copies.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    engine_.submit(copies);
    engine_.wait(copies);
    std::vector<std::byte> bytes(range.size);
    std::memcpy(bytes.data(), out.mapped, bytes.size());
    engine_.destroyBuffer(out);
    return bytes;
  }

  const Engine& engine_;
  Scene scene_;
  DeliveryScene inputs_;
  std::optional<vulkan::Runtime> runtime_;
};

class VulkanTwoScenes : public testing::Test {
 protected:
  void SetUp() override {
    std::string reason;
    engine_ = Engine::create(reason);
    if (engine_ == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << reason;
    for (Engine::Frame& slot : slots_) slot = engine_->createFrame();
  }
  void TearDown() override {
    if (engine_ == nullptr) return;
    for (const Engine::Frame& slot : slots_) engine_->destroyFrame(slot);
    EXPECT_EQ(engine_->messageCount(), 0u);
  }
  // Frames of all players, in one command buffer.
  std::vector<std::vector<Results>> play(std::initializer_list<Solver> solvers) {
    std::vector<std::unique_ptr<Player>> players;
    for (const Solver solver : solvers)
      players.push_back(std::make_unique<Player>(*engine_, solver));
    std::vector<std::vector<Results>> all(players.size());
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      engine_->begin(slots_[0]);
      for (const auto& player : players) player->record(frame, slots_[0].commands);
      engine_->submit(slots_[0]);
      for (const auto& player : players) player->submitted();
      engine_->wait(slots_[0]);
      for (size_t i = 0; i < players.size(); ++i) all[i].push_back(players[i]->read(slots_[1]));
    }
    return all;
  }

  std::unique_ptr<Engine> engine_;
  Engine::Frame slots_[2];
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
  engine_->begin(slots_[0]);
  one.record(0, slots_[0].commands);
  const Result<void> updated = one.runtime().update(other.scene().resources(), slots_[0].commands);
  ASSERT_FALSE(updated);
  EXPECT_NE(updated.error().message.find("another ResourceTable"), std::string::npos);
  Result<Frame> frame = other.scene().simulate(0);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(one.runtime().record(*frame, slots_[0].commands));
  engine_->submit(slots_[0]);
  one.submitted();
  engine_->wait(slots_[0]);
}

}  // namespace
}  // namespace pelage::test
