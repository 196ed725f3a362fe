// pelage/vulkan.h as an engine uses it: on the engine's device, in the engine's command buffers,
// with several frames in flight.

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "pelage/assert.h"
#include "runtime_test/layouts.h"
#include "runtime_test/spirv.h"
#include "support/errors.h"
#include "support/own_device.h"
#include "support/texture_list.h"
#include "vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;
using runtime_test::EngineImage;
using runtime_test::EngineRun;
using runtime_test::tagged;
using vulkan::Runtime;
using vulkan::RuntimeDef;

constexpr uint32_t kElements = 5000;
constexpr uint64_t kElementBytes = kElements * sizeof(uint32_t);
constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                      VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                      VK_BUFFER_USAGE_TRANSFER_SRC_BIT;

// An engine's allocator that remembers what lives.
struct CountingAllocator {
  const Engine* engine = nullptr;
  std::vector<EngineBuffer> live;
  uint32_t created = 0;
  bool fails = false;
  VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;

  vulkan::BufferAllocator hooks() {
    return {this,
            [](void* user, const VkBufferCreateInfo& info, vulkan::MemoryKind kind, const char*,
               vulkan::AllocatedBuffer& out) {
              auto& self = *static_cast<CountingAllocator*>(user);
              if (self.fails) return self.failure;
              const EngineBuffer made = self.engine->createBuffer(
                  info.size, info.usage, kind != vulkan::MemoryKind::kDevice);
              self.live.push_back(made);
              ++self.created;
              out = {made.buffer, made.mapped, nullptr};
              return VK_SUCCESS;
            },
            [](void* user, const vulkan::AllocatedBuffer& buffer) {
              auto& self = *static_cast<CountingAllocator*>(user);
              for (const EngineBuffer& candidate : self.live)
                if (candidate.buffer == buffer.buffer) self.engine->destroyBuffer(candidate);
              std::erase_if(self.live, [&](const EngineBuffer& candidate) {
                return candidate.buffer == buffer.buffer;
              });
            }};
  }
};

class VulkanEngine : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override { open(); }
  void TearDown() override { close(); }
  void createRuntime(RuntimeDef def) {
    def.code.push_back(runtime_test::allSpirv());
    EngineRun::createRuntime(def);
  }
  void createRuntime(CountingAllocator& allocator) {
    allocator.engine = engine_.get();
    RuntimeDef def = engine_->runtimeDef();
    def.allocator = allocator.hooks();
    createRuntime(def);
  }
  void finishFrames() {
    waitForFrames();
    runtime_->collect(frame_);
  }
  BufferId add(const char* name, uint32_t first) {
    return table_.add(name, ramp(first, kElements), BufferUsage::kStorage | BufferUsage::kUpload);
  }
  void accumulate(PassList& list, BufferId source, BufferId target, uint32_t factor,
                  uint32_t bias) {
    addAccumulate(list, source, target, kElements, factor, bias);
  }
  // Copies a buffer of the table to memory that the host reads when the frame is done.
  void copyOut(VkCommandBuffer commands, BufferId id, const EngineBuffer& out) const {
    const vulkan::BufferRange range = runtime_->buffer(id);
    auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    vkCmdPipelineBarrier(commands,
                         VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    const VkBufferCopy copy = {range.offset, 0, range.size};
    vkCmdCopyBuffer(commands, range.buffer, out.buffer, 1, &copy);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_PIPELINE_STAGE_HOST_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1,
                         &barrier, 0, nullptr, 0, nullptr);
  }
  static std::vector<uint32_t> wordsOf(const EngineBuffer& buffer) {
    return valuesOf<uint32_t>({static_cast<const std::byte*>(buffer.mapped), kElementBytes});
  }

  ResourceTable table_;
  HazardTracker tracker_;
};

TEST_F(VulkanEngine, KnowsTexturesUntilTheyAreForgotten) {
  createRuntime(engine_->runtimeDef());
  const TextureId texture = newTextureId();
  // These handles are of no object: no list gets as far as to use them.
  int view = 0, sampler = 0;
  const auto viewHandle = reinterpret_cast<VkImageView>(&view);
  const auto samplerHandle = reinterpret_cast<VkSampler>(&sampler);
  const auto messageOf = [&] {
    const Engine::Frame& frame = beginFrame();
    PassList list = listWithTexture(texture);
    const Result<void> recorded = runtime_->record(list, frame.commands);
    submit(frame);
    return recorded ? std::string() : recorded.error().message;
  };
  constexpr const char* kUnknown = "'g_picture': the runtime does not know the texture";
  constexpr const char* kNoSampler = "'g_pictureSampler': the texture was registered without";
  expectHas(messageOf(), kUnknown);
  runtime_->registerTexture(texture, {.view = viewHandle});
  expectHas(messageOf(), kNoSampler);
  runtime_->registerTexture(texture, {.view = viewHandle, .sampler = samplerHandle});
  const std::string other = messageOf();
  EXPECT_FALSE(other.empty()) << "the kernel has no code";
  EXPECT_EQ(other.find("texture"), std::string::npos) << other;
  runtime_->registerTexture(texture, {});
  expectHas(messageOf(), kUnknown);
  finishFrames();
}

TEST_F(VulkanEngine, UploadsAndConstantsOfThreeFramesInFlightStayApart) {
  createRuntime(engine_->runtimeDef());
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  constexpr uint32_t kFrames = 30;
  std::vector<EngineBuffer> outs;
  std::vector<std::vector<uint32_t>> expected;
  std::vector<uint32_t> state = ramp(0, kElements);
  for (uint32_t i = 0; i < kFrames; ++i) {
    outs.push_back(engine_->createBuffer(kElementBytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true));
    const Engine::Frame& frame = beginFrame();
    ASSERT_TRUE(runtime_->update(table_, frame.commands));
    PassList list;
    const std::vector<uint32_t> fresh = ramp(i * 1000, kElements);
    addUpload(list, source, std::as_bytes(std::span(fresh)));
    accumulate(list, source, target, i + 1, 3 * i);
    tracker_.resolve(list);
    expectOk(runtime_->record(list, frame.commands));
    copyOut(frame.commands, target, outs.back());
    submit(frame);
    for (uint32_t j = 0; j < kElements; ++j) state[j] = 3 * state[j] + (i + 1) * fresh[j] + 3 * i;
    expected.push_back(state);
  }
  finishFrames();
  for (uint32_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(wordsOf(outs[i]), expected[i]) << "frame " << i;
    engine_->destroyBuffer(outs[i]);
  }
}

TEST_F(VulkanEngine, DestroysARemovedBufferOnlyAfterTheFrameThatUsedItHasCompleted) {
  CountingAllocator allocator;
  createRuntime(allocator);
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);

  const Engine::Frame& first = beginFrame();
  ASSERT_TRUE(runtime_->update(table_, first.commands));
  const VkBuffer handle = runtime_->buffer(target).buffer;
  PassList list;
  accumulate(list, source, target, 1, 1);
  tracker_.resolve(list);
  ASSERT_TRUE(runtime_->record(list, first.commands));
  submit(first);

  const auto lives = [&] {
    for (const EngineBuffer& buffer : allocator.live)
      if (buffer.buffer == handle) return true;
    return false;
  };
  table_.remove(target);
  const Engine::Frame& second = beginFrame();
  ASSERT_TRUE(runtime_->update(table_, second.commands));
  EXPECT_EQ(runtime_->buffer(target).buffer, VkBuffer{VK_NULL_HANDLE});
  EXPECT_TRUE(lives());
  submit(second);
  engine_->wait(first);
  engine_->wait(second);
  runtime_->collect(1);
  EXPECT_TRUE(lives()) << "frame 2 may still name it";
  runtime_->collect(2);
  EXPECT_FALSE(lives());

  finishFrames();
  runtime_.reset();
  EXPECT_GT(allocator.created, 3u);
  EXPECT_TRUE(allocator.live.empty());
}

TEST_F(VulkanEngine, AFailedUpdateChangesNothingAndCanBeRepeated) {
  CountingAllocator allocator;
  createRuntime(allocator);
  const BufferId source = add("source", 0);
  const Engine::Frame& frame = beginFrame();
  allocator.fails = true;
  expectError(runtime_->update(table_, frame.commands), ErrorCode::kOutOfMemory, "'source'");
  EXPECT_EQ(runtime_->buffer(source).buffer, VkBuffer{VK_NULL_HANDLE});
  allocator.fails = false;
  expectOk(runtime_->update(table_, frame.commands));
  EXPECT_NE(runtime_->buffer(source).buffer, VkBuffer{VK_NULL_HANDLE});
  submit(frame);
  finishFrames();
  runtime_.reset();
}

TEST_F(VulkanEngine, SaysThatTheDeviceIsLost) {
  CountingAllocator allocator;
  createRuntime(allocator);
  add("source", 0);
  const Engine::Frame& frame = beginFrame();
  allocator.fails = true;
  allocator.failure = VK_ERROR_DEVICE_LOST;
  expectError(runtime_->update(table_, frame.commands), ErrorCode::kDeviceLost,
              {"'source'", "VK_ERROR_DEVICE_LOST", "Scene::recover()"});
  submit(frame);
  finishFrames();
  runtime_.reset();
}

TEST_F(VulkanEngine, RunsOnABufferOfTheEngineAtAnOffset) {
  createRuntime(engine_->runtimeDef());
  const BufferId source = add("source", 1);
  const BufferId target = add("target", 2);
  const BufferId kept = add("kept", 3);
  constexpr VkDeviceSize kOffset = 512;  // a multiple of every device's alignment
  const EngineBuffer own = engine_->createBuffer(kOffset + kElementBytes, kUsage, true);
  std::memset(own.mapped, 0xab, kOffset + kElementBytes);
  const EngineBuffer contents = engine_->createBuffer(kElementBytes, kUsage, true);
  std::memset(contents.mapped, 0, kElementBytes);
  runtime_->registerBuffer(target, {own.buffer, kOffset, false});
  runtime_->registerBuffer(kept, {contents.buffer, 0, true});
  const Engine::Frame& frame = beginFrame();
  ASSERT_TRUE(runtime_->update(table_, frame.commands));
  EXPECT_EQ(runtime_->buffer(target).buffer, own.buffer);
  EXPECT_EQ(runtime_->buffer(target).offset, kOffset);
  PassList list;
  accumulate(list, source, target, 10, 0);
  accumulate(list, source, kept, 10, 0);
  tracker_.resolve(list);
  ASSERT_TRUE(runtime_->record(list, frame.commands));
  auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(frame.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                       VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
  submit(frame);
  finishFrames();
  const auto* bytes = static_cast<const std::byte*>(own.mapped);
  for (VkDeviceSize i = 0; i < kOffset; ++i) ASSERT_EQ(bytes[i], std::byte{0xab}) << i;
  const std::vector<uint32_t> inherited = wordsOf(contents);
  for (uint32_t i = 0; i < kElements; ++i) {
    uint32_t value;
    std::memcpy(&value, bytes + kOffset + i * sizeof(value), sizeof(value));
    ASSERT_EQ(value, 3 * (i + 2) + 10 * (i + 1)) << i;
    ASSERT_EQ(inherited[i], 10 * (i + 1)) << i;
  }
  runtime_.reset();
  engine_->destroyBuffer(own);
  engine_->destroyBuffer(contents);
}

TEST_F(VulkanEngine, RefusesABufferOfTheEngineThatIsTooSmallByName) {
  createRuntime(engine_->runtimeDef());
  const BufferId target = add("target", 2);
  const EngineBuffer tiny = engine_->createBuffer(64, kUsage, false);
  const EngineBuffer large = engine_->createBuffer(kElementBytes + 512, kUsage, false);
  const Engine::Frame& frame = beginFrame();
  const vulkan::ExternalBuffer wrongs[] = {
      {.buffer = tiny.buffer},
      {.buffer = tiny.buffer, .keepContents = true},
      {.buffer = tiny.buffer, .size = kElementBytes},  // it has not what it says
      {.buffer = large.buffer, .size = kElementBytes - 4},
      {.buffer = large.buffer, .offset = 4096},
      {.buffer = large.buffer, .offset = VkDeviceSize{1} << 40},
      {.buffer = large.buffer, .offset = 512, .size = 0},
  };
  for (const vulkan::ExternalBuffer& wrong : wrongs) {
    runtime_->registerBuffer(target, wrong);
    expectError(runtime_->update(table_, frame.commands), ErrorCode::kInvalidArgument,
                {"'target'", "it needs 20000"});
    EXPECT_EQ(runtime_->buffer(target).buffer, VkBuffer{VK_NULL_HANDLE});
  }
  // The last one counts.
  runtime_->registerBuffer(target, {.buffer = large.buffer, .offset = 512, .size = kElementBytes});
  // A null buffer is an assertion, and no buffer where its handler returns.
  static std::string asserted;
  setAssertHandler([](const char*, const char* message, const char*, int) { asserted = message; });
  runtime_->registerBuffer(target, {});
  setAssertHandler(nullptr);
  EXPECT_EQ(asserted, "an external buffer is a buffer");
  expectOk(runtime_->update(table_, frame.commands));
  EXPECT_EQ(runtime_->buffer(target).buffer, large.buffer);
  EXPECT_EQ(runtime_->buffer(target).size, kElementBytes);
  submit(frame);
  finishFrames();
  runtime_.reset();
  engine_->destroyBuffer(tiny);
  engine_->destroyBuffer(large);
}

TEST_F(VulkanEngine, MakesThePipelinesOfAListOnSeveralThreadsAndEachOnce) {
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  for (const uint32_t threads : {1u, 4u, 0u}) {
    RuntimeDef def = engine_->runtimeDef();
    def.pipelineThreads = threads;
    createRuntime(def);
    PassList list;
    for (int round = 0; round < 2; ++round) {
      for (const bool doubled : {false, true}) {
        addAccumulate(list, source, target, kElements, 1, 0, doubled);
      }
    }
    ASSERT_TRUE(runtime_->prepare(list));
    ASSERT_TRUE(runtime_->prepare(list));
    const std::vector<PipelineTime> times = runtime_->pipelineTimes();
    ASSERT_EQ(times.size(), 2u) << threads;
    EXPECT_NE(times[0].name, times[1].name);
    for (const PipelineTime& time : times) {
      expectHas(time.name, "accumulate");
      EXPECT_GT(time.milliseconds, 0);
    }
  }
}

TEST_F(VulkanEngine, KeepsTheOtherPipelinesOfAListWithABrokenKernel) {
  createRuntime(engine_->runtimeDef());
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  KernelVariant unknown = runtime_test::accumulateVariant({.doubled = true});
  unknown.hash = 0;
  PassList list;
  accumulate(list, source, target, 1, 0);
  accumulate(list, source, target, 1, 0);
  list.passes[0].kernel = &unknown;
  expectError(runtime_->prepare(list), "doubled=1");
  EXPECT_EQ(runtime_->pipelineTimes().size(), 1u);
  list.passes[0].kernel = &runtime_test::accumulateVariant();
  EXPECT_TRUE(runtime_->prepare(list));
  EXPECT_EQ(runtime_->pipelineTimes().size(), 1u);
}

TEST_F(VulkanEngine, MakesEachLayoutOnceThroughItsTemplate) {
  createRuntime(engine_->runtimeDef());
  const Result<VkDescriptorSetLayout> first = runtime_test::CreateRuntimeComputeLayout(*runtime_);
  const Result<VkDescriptorSetLayout> again = runtime_test::CreateRuntimeComputeLayout(*runtime_);
  const Result<VkDescriptorSetLayout> other = runtime_test::CreateRuntimeDrawLayout(*runtime_);
  ASSERT_TRUE(first);
  ASSERT_TRUE(other);
  EXPECT_NE(*first, VkDescriptorSetLayout{VK_NULL_HANDLE});
  EXPECT_EQ(*first, *again);
  EXPECT_NE(*first, *other);
}

TEST_F(VulkanEngine, TakesBackThePipelineCacheOfAnEarlierRunAndIgnoresAForeignOne) {
  createRuntime(engine_->runtimeDef());
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  PassList list;
  accumulate(list, source, target, 1, 1);
  ASSERT_TRUE(runtime_->prepare(list));
  const Result<std::vector<std::byte>> data = required(runtime_->pipelineCacheData());
  ASSERT_GE(data->size(), sizeof(VkPipelineCacheHeaderVersionOne));

  std::vector<std::byte> foreign = *data;
  foreign[offsetof(VkPipelineCacheHeaderVersionOne, pipelineCacheUUID)] ^= std::byte{1};
  const std::vector<std::byte> cut(data->begin(), data->begin() + 7);
  for (const std::vector<std::byte>& bytes : {*data, foreign, cut}) {
    RuntimeDef def = engine_->runtimeDef();
    def.pipelineCacheData = bytes;
    createRuntime(def);
    EXPECT_TRUE(runtime_->prepare(list));
  }
}

TEST_F(VulkanEngine, RefusesFramesWhenNoneIsEverSaidToHaveCompleted) {
  RuntimeDef def = engine_->runtimeDef();
  EXPECT_EQ(def.maxFramesInFlight, 64u);
  def.maxFramesInFlight = 8;
  createRuntime(def);
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  const auto record = [&](uint64_t completed) {
    ++frame_;
    const Engine::Frame& slot = frames_[frame_ % kFramesInFlight];
    engine_->begin(slot);
    runtime_->beginFrame(frame_, completed);
    Result<void> done = runtime_->update(table_, slot.commands);
    PassList list;
    const std::vector<uint32_t> fresh = ramp(1, kElements);
    addUpload(list, source, std::as_bytes(std::span(fresh)));
    accumulate(list, source, target, 1, 1);
    tracker_.resolve(list);
    if (done) done = runtime_->record(list, slot.commands);
    submit(slot);
    return done;
  };
  EXPECT_EQ(runtime_->memoryUse().frameBytes, 0u);
  uint64_t bytes = 0;
  for (uint32_t i = 1; i <= 8; ++i) {
    ASSERT_TRUE(record(0));
    const vulkan::MemoryUse use = runtime_->memoryUse();
    EXPECT_EQ(use.framesInFlight, i);
    EXPECT_EQ(use.bufferBytes, runtime_->bufferBytes());
    EXPECT_EQ(use.bufferBytes, 2 * kElementBytes);
    EXPECT_GT(use.frameBytes, bytes) << "what a frame has taken is not used again";
    bytes = use.frameBytes;
  }
  // Without end, if it were for the engine.
  for (int i = 0; i < 100; ++i) {
    expectError(record(0), ErrorCode::kInvalidArgument,
                {"8 frames, from frame 1 on", "fence", "maxFramesInFlight"});
    EXPECT_EQ(runtime_->memoryUse().frameBytes, bytes);
    EXPECT_EQ(runtime_->memoryUse().framesInFlight, 8u);
  }
  // With the number, it goes on, in the memory that it has.
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(record(frame_ - kFramesInFlight + 1));
    EXPECT_LE(runtime_->memoryUse().framesInFlight, kFramesInFlight);
    EXPECT_EQ(runtime_->memoryUse().frameBytes, bytes);
  }
  finishFrames();
  EXPECT_EQ(runtime_->memoryUse().framesInFlight, 0u);

  // No bound.
  def.maxFramesInFlight = 0;
  tracker_.forgetExecutor();
  createRuntime(def);
  frame_ = 1'000'000;  // numbers of an engine begin anywhere
  for (int i = 0; i < 70; ++i) ASSERT_TRUE(record(0));
  EXPECT_EQ(runtime_->memoryUse().framesInFlight, 70u);
  finishFrames();
}

TEST_F(VulkanEngine, MeasuresPassesOfCompletedFrames) {
  createRuntime(engine_->runtimeDef());
  const BufferId source = add("source", 0);
  const BufferId target = add("target", 0);
  runtime_->setTimestamps(true);
  for (uint32_t i = 0; i < 8; ++i) {
    const Engine::Frame& frame = beginFrame();
    ASSERT_TRUE(runtime_->update(table_, frame.commands));
    PassList list;
    for (uint32_t j = 0; j <= i; ++j) accumulate(list, source, target, 1, 1);
    tracker_.resolve(list);
    ASSERT_TRUE(runtime_->record(list, frame.commands));
    submit(frame);
    EXPECT_TRUE(runtime_->timings(frame_).empty());
    if (frame_ <= kFramesInFlight) continue;
    const std::vector<PassTiming> timings = runtime_->timings(frame_ - kFramesInFlight);
    ASSERT_EQ(timings.size(), i + 1 - kFramesInFlight);
    for (const PassTiming& timing : timings) EXPECT_GE(timing.milliseconds, 0);
  }
  finishFrames();
  EXPECT_EQ(runtime_->timings(frame_).size(), 8u);
}

TEST_F(VulkanEngine, DrawsInsideDynamicRendering) {
  if (!engine_->dynamicRendering()) GTEST_SKIP() << "the device is older than Vulkan 1.3";
  createRuntime(engine_->runtimeDef());
  constexpr uint32_t kSize = 16;
  const BufferId triangle =
      table_.add("triangle", kEverything, BufferUsage::kStorage | BufferUsage::kUpload);
  const EngineImage image =
      engine_->createImage(VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_ASPECT_COLOR_BIT, kSize);
  const EngineBuffer out = engine_->createBuffer(VkDeviceSize{kSize} * kSize * 4,
                                                 VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);

  PassList list;
  addFill(list, {}, triangle, 3, {{1, 0, 1, 1}, {}});
  tracker_.resolve(list);
  const Engine::Frame& frame = beginFrame();
  ASSERT_TRUE(runtime_->update(table_, frame.commands));
  ASSERT_TRUE(runtime_->record(list, frame.commands));
  const auto transition = [&](VkImageLayout from, VkImageLayout to, VkPipelineStageFlags before,
                              VkAccessFlags written, VkPipelineStageFlags after,
                              VkAccessFlags next) {
    auto barrier = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
    barrier.srcAccessMask = written;
    barrier.dstAccessMask = next;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.image;
    barrier.subresourceRange = {image.aspects, 0, 1, 0, 1};
    vkCmdPipelineBarrier(frame.commands, before, after, 0, 0, nullptr, 0, nullptr, 1, &barrier);
  };
  transition(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
             VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
             VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT);
  auto attachment = tagged<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  attachment.imageView = image.view;
  attachment.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  auto rendering = tagged<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  rendering.renderArea.extent = {kSize, kSize};
  rendering.layerCount = 1;
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachments = &attachment;
  vkCmdBeginRendering(frame.commands, &rendering);
  vulkan::TargetFormats target;
  target.color = image.format;
  target.depth = VK_FORMAT_UNDEFINED;
  // A part of the image: its right half.
  const VkRect2D area = {{kSize / 2, 0}, {kSize / 2, kSize}};
  expectOk(runtime_->recordDraws(list, frame.commands, target, area));
  vkCmdEndRendering(frame.commands);
  transition(VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
             VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
             VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  VkBufferImageCopy copy = {};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = {kSize, kSize, 1};
  vkCmdCopyImageToBuffer(frame.commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                         out.buffer, 1, &copy);
  submit(frame);
  finishFrames();
  std::array<uint32_t, size_t{kSize} * kSize> pixels;
  std::memcpy(pixels.data(), out.mapped, sizeof(pixels));
  for (uint32_t i = 0; i < pixels.size(); ++i)
    ASSERT_EQ(pixels[i], i % kSize >= kSize / 2 ? 0xffff00ffu : 0u) << i;
  runtime_.reset();
  engine_->destroyBuffer(out);
  engine_->destroyImage(image);
}

TEST_F(VulkanEngine, NamesTheFeatureThatAVertexKernelThatWritesNeeds) {
  createRuntime(engine_->runtimeDef());  // made without any feature
  KernelVariant writing = runtime_test::fillVertexVariant();
  std::vector<VariantBinding> bindings(writing.bindings.begin(), writing.bindings.end());
  bindings.back().access = Access::kReadWrite;
  writing.bindings = bindings;
  const BufferId triangle = add("triangle", 0);
  PassList list;
  addFill(list, {}, triangle, 3);
  list.passes[0].kernel = &writing;
  const vulkan::TargetFormats target;
  expectError(runtime_->prepare(list, &target), ErrorCode::kUnsupported,
              {"vertexPipelineStoresAndAtomics", "fill_vertex"});
}

TEST_F(VulkanEngine, NamesWhatIsMissingFromTheDefinition) {
  const auto messageOf = [](const RuntimeDef& def) {
    const Result<Runtime> made = Runtime::create(def);
    EXPECT_FALSE(made);
    return made ? std::string() : made.error().message;
  };
  RuntimeDef def = engine_->runtimeDef();
  def.device = VK_NULL_HANDLE;
  expectHas(messageOf(def), "RuntimeDef::device");
  def = engine_->runtimeDef();
  def.queueFamily = 77;
  expectHas(messageOf(def), "queueFamily is 77");
  def = engine_->runtimeDef();
  def.getInstanceProcAddr = [](VkInstance, const char*) -> PFN_vkVoidFunction { return nullptr; };
  expectHas(messageOf(def), "no function vk");
}

}  // namespace
}  // namespace pelage::test
