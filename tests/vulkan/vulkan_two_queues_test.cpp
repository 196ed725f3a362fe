// Simulation on a queue that only computes, draws on another one: positions, shadow maps and pixels
// are those of one queue, and no command of the first queue names a stage of draws.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/views.h"
#include "vulkan/vulkan_engine.h"
#include "vulkan/vulkan_target.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineRun;
using runtime_test::tagged;

// Records what the runtime calls. Where a device has one family, the runtime sees a second one that
// only computes; its command buffers go to the queue of the first.
struct Watch {
  bool pretends = false;
  uint32_t pretended = 0;  // the family that is not there
  VkCommandBuffer compute = VK_NULL_HANDLE;
  VkPipelineStageFlags stages = 0;  // of barriers in `compute`
  VkAccessFlags access = 0;
  uint32_t barriers = 0;
  uint32_t buffers = 0, concurrent = 0;
} watch;

VKAPI_ATTR void VKAPI_CALL queueFamilies(VkPhysicalDevice device, uint32_t* count,
                                         VkQueueFamilyProperties* families) {
  const uint32_t room = *count;
  vkGetPhysicalDeviceQueueFamilyProperties(device, count, families);
  if (!watch.pretends) return;
  watch.pretended = *count;
  if (families == nullptr) {
    ++*count;
  } else if (room > *count) {
    families[*count] = families[0];
    families[(*count)++].queueFlags = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
  }
}

VKAPI_ATTR VkResult VKAPI_CALL createBuffer(VkDevice device, const VkBufferCreateInfo* asked,
                                            const VkAllocationCallbacks* callbacks,
                                            VkBuffer* buffer) {
  VkBufferCreateInfo info = *asked;
  ++watch.buffers;
  if (info.sharingMode == VK_SHARING_MODE_CONCURRENT && info.queueFamilyIndexCount == 2)
    ++watch.concurrent;
  if (watch.pretends) info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  return vkCreateBuffer(device, &info, callbacks, buffer);
}

VKAPI_ATTR void VKAPI_CALL pipelineBarrier(VkCommandBuffer commands, VkPipelineStageFlags before,
                                           VkPipelineStageFlags after, VkDependencyFlags flags,
                                           uint32_t memoryCount, const VkMemoryBarrier* memory,
                                           uint32_t bufferCount,
                                           const VkBufferMemoryBarrier* buffers,
                                           uint32_t imageCount,
                                           const VkImageMemoryBarrier* images) {
  if (commands == watch.compute) {
    ++watch.barriers;
    watch.stages |= before | after;
    for (uint32_t i = 0; i < bufferCount; ++i)
      watch.access |= buffers[i].srcAccessMask | buffers[i].dstAccessMask;
  }
  vkCmdPipelineBarrier(commands, before, after, flags, memoryCount, memory, bufferCount, buffers,
                       imageCount, images);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL deviceFunction(VkDevice device, const char* name) {
  if (std::string_view(name) == "vkCreateBuffer")
    return reinterpret_cast<PFN_vkVoidFunction>(createBuffer);
  if (std::string_view(name) == "vkCmdPipelineBarrier")
    return reinterpret_cast<PFN_vkVoidFunction>(pipelineBarrier);
  return vkGetDeviceProcAddr(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instanceFunction(VkInstance instance, const char* name) {
  if (std::string_view(name) == "vkGetPhysicalDeviceQueueFamilyProperties")
    return reinterpret_cast<PFN_vkVoidFunction>(queueFamilies);
  if (std::string_view(name) == "vkGetDeviceProcAddr")
    return reinterpret_cast<PFN_vkVoidFunction>(deviceFunction);
  return vkGetInstanceProcAddr(instance, name);
}

class VulkanTwoQueues : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override {
    VkPhysicalDeviceFeatures features = {};
    features.fragmentStoresAndAtomics = VK_TRUE;
    open(features);
    if (engine_ == nullptr) return;
    watch = {.pretends = engine_->computeFamily() == engine_->family()};
    compute_ = engine_->createFrame(engine_->computeFamily());
    for (VkSemaphore& semaphore : semaphores_) {
      const auto info = tagged<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
      ASSERT_EQ(vkCreateSemaphore(engine_->device(), &info, nullptr, &semaphore), VK_SUCCESS);
    }
  }
  void TearDown() override {
    if (engine_ == nullptr) return;
    engine_->destroyFrame(compute_);
    for (const VkSemaphore semaphore : semaphores_)
      vkDestroySemaphore(engine_->device(), semaphore, nullptr);
    close();
  }
  // The family that only computes, as the runtime sees it.
  uint32_t computeFamily() const {
    return watch.pretends ? engine_->family() + 1 : engine_->computeFamily();
  }
  vulkan::RuntimeDef runtimeDef() const {
    vulkan::RuntimeDef def = engine_->runtimeDef();
    def.getInstanceProcAddr = instanceFunction;
    return def;
  }

  // The simulation waits for the views of the frame before, and the views for the simulation.
  void submitBoth(bool isFirst, const Engine::Frame& views) {
    const VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const auto send = [&](const Engine::Frame& frame, VkQueue queue, const VkSemaphore* waits,
                          const VkSemaphore* signals) {
      ASSERT_EQ(vkEndCommandBuffer(frame.commands), VK_SUCCESS);
      auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
      info.waitSemaphoreCount = waits != nullptr ? 1 : 0;
      info.pWaitSemaphores = waits;
      info.pWaitDstStageMask = &all;
      info.commandBufferCount = 1;
      info.pCommandBuffers = &frame.commands;
      info.signalSemaphoreCount = 1;
      info.pSignalSemaphores = signals;
      ASSERT_EQ(vkQueueSubmit(queue, 1, &info, frame.fence), VK_SUCCESS);
    };
    send(compute_, engine_->computeQueue(), isFirst ? nullptr : &semaphores_[1], &semaphores_[0]);
    send(views, engine_->queue(), &semaphores_[0], &semaphores_[1]);
  }

  // Results and pixels of each frame.
  std::vector<DeliveryScene::Results> play(bool twoQueues) {
    vulkan::RuntimeDef def = runtimeDef();
    if (twoQueues) def.otherQueueFamilies = {computeFamily()};
    createRuntime(def);
    Scene scene;
    DeliveryScene inputs(scene, Solver::kClassic);
    const TargetKind kind = {.name = "color and depth", .dynamic = false};
    VulkanTarget target(*engine_, kind);
    // The hair is there from frame 3 on.
    const View view = cameraView(
        {.eye = {1.8f, 0.04f, 0.4f}, .target = {1.8f, 0.04f, 0}, .width = VulkanTarget::kSize});
    std::vector<DeliveryScene::Results> all;
    for (int index = 0; index < DeliveryScene::kFrames; ++index) {
      const Engine::Frame& views = frames_[0];
      engine_->begin(views);
      if (twoQueues) {
        engine_->begin(compute_);
        watch.compute = compute_.commands;
      }
      runtime_->beginFrame(static_cast<uint64_t>(index) + 1, static_cast<uint64_t>(index));
      inputs.setInputs(index);
      Frame frame = inputs.makeFrame(index);
      const Light light = {.shadow = HairShadow::kDeep, .shadowSize = DeliveryScene::kShadowSize};
      EXPECT_TRUE(frame.draw(view, {&light, 1}));
      target.prepare(views.commands);
      vulkan::ViewTarget to;
      to.formats = target.formats();
      to.area = {{0, 0}, {VulkanTarget::kSize, VulkanTarget::kSize}};
      to.begin = [&](const FrameStep& step) { target.begin(views.commands, step.listOfView == 0); };
      to.end = [&](const FrameStep&) { target.end(views.commands); };
      expectOk(twoQueues ? runtime_->record(frame, {compute_.commands, computeFamily()},
                                            views.commands, {&to, 1})
                         : runtime_->record(frame, views.commands, {&to, 1}));
      const std::vector<runtime_test::EngineBuffer> outs = target.copyOut(views.commands);
      if (twoQueues)
        submitBoth(index == 0, views);
      else
        engine_->submit(views);
      runtime_->submitted();
      engine_->wait(views);
      all.push_back(inputs.readResults([this](BufferId id) { return read(id); }));
      all.back().emplace_back(size_t{VulkanTarget::kSize} * VulkanTarget::kSize * 4);
      std::memcpy(all.back().back().data(), outs[0].mapped, all.back().back().size());
      for (const runtime_test::EngineBuffer& out : outs) engine_->destroyBuffer(out);
    }
    return all;
  }

  Engine::Frame compute_;
  VkSemaphore semaphores_[2] = {};
};

TEST_F(VulkanTwoQueues, HaveTheBitsOfOne) {
  const std::vector<DeliveryScene::Results> one = play(false);
  EXPECT_EQ(watch.concurrent, 0u);
  const uint32_t before = watch.buffers;
  const std::vector<DeliveryScene::Results> two = play(true);
  EXPECT_EQ(two, one);
  ASSERT_NE(one[4].back(), one[0].back()) << "there is no hair in the picture";
  EXPECT_EQ(watch.concurrent, watch.buffers - before);
  EXPECT_GT(watch.barriers, 20u);
  constexpr VkPipelineStageFlags kOnCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT |
                                              VK_PIPELINE_STAGE_TRANSFER_BIT |
                                              VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  EXPECT_EQ(watch.stages & ~kOnCompute, 0u);
  EXPECT_EQ(watch.access & (VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT), 0u);
}

TEST_F(VulkanTwoQueues, FamiliesThatAreNotNamedAreRefused) {
  createRuntime(runtimeDef());
  expectError(runtime_->useQueueFamily(computeFamily()), {"otherQueueFamilies"});
  vulkan::RuntimeDef def = runtimeDef();
  def.otherQueueFamilies = {1000};
  expectError(vulkan::Runtime::create(def), {"otherQueueFamilies", "1000"});
  def.otherQueueFamilies = {computeFamily(), def.queueFamily};
  createRuntime(def);
  expectOk(runtime_->useQueueFamily(computeFamily()));
  Scene scene;
  ASSERT_TRUE(scene.addHair(makeAsset(4), {.name = "hair"}));
  Result<Frame> frame = required(scene.simulate(0));
  engine_->begin(compute_);
  runtime_->beginFrame(1, 0);
  expectError(runtime_->record(*frame, {compute_.commands, 1000}, compute_.commands),
              {"queue family 1000"});
  engine_->discard(compute_);
}

}  // namespace
}  // namespace pelage::test
