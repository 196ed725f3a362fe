// A Vulkan device without a window: makes instance, device and queues, or shares those of another
// one, runs pass lists through the runtime, waits, and reads results back.

#include "pelage/headless.h"
#include "pelage/list_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "buffer_memory.h"
#include "own_device.h"
#include "pelage/vulkan.h"
#include "render_target.h"
#include "texture.h"

namespace pelage {
namespace vulkan {
namespace {

constexpr uint32_t kMaxTargetSize = 16384;
/// Bytes of a read that are staged at once.
constexpr VkDeviceSize kMaxReadback = VkDeviceSize{64} << 20;

// The widening is exact: every half is a float.
float halfToFloat(uint16_t half) {
  const uint32_t sign = static_cast<uint32_t>(half & 0x8000u) << 16;
  const uint32_t exponent = half >> 10 & 0x1fu;
  const uint32_t mantissa = half & 0x3ffu;
  if (exponent == 0x1f) return std::bit_cast<float>(sign | 0x7f800000u | mantissa << 13);
  if (exponent != 0)
    return std::bit_cast<float>(sign | (exponent + (127 - 15)) << 23 | mantissa << 13);
  const float value = static_cast<float>(mantissa) * 0x1p-24f;  // subnormal
  return sign != 0 ? -value : value;
}

// One command buffer and its runtime. Each frame is waited for, so that all earlier ones have
// completed.
class WaitedFrames {
 public:
  explicit WaitedFrames(OwnDevice& device) : own_(device) {}
  WaitedFrames(const WaitedFrames&) = delete;
  WaitedFrames& operator=(const WaitedFrames&) = delete;
  ~WaitedFrames() {
    runtime_.reset();
    device_.vk.DestroyFence(device_.handle, fence_, nullptr);
    device_.vk.DestroyCommandPool(device_.handle, pool_, nullptr);
  }

  Result<void> create(Tier maxTier);
  Runtime& runtime() { return *runtime_; }
  const Runtime& runtime() const { return *runtime_; }
  VkCommandBuffer commands() const { return commands_; }
  /// Whether the wait for a submission failed.
  bool isRunning() const { return running_; }
  std::vector<PassTiming> timings() { return runtime_->timings(frame_); }

  /// Starts a frame and its command buffer.
  Result<void> begin();
  /// Ends, submits, waits.
  Result<void> submit();
  /// Takes back a command buffer that was not submitted.
  void abandon();

 private:
  OwnDevice& own_;
  const Device& device_ = own_.device();
  OwnQueue& queue_ = own_.nextQueue();
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  uint64_t frame_ = 0;
  bool running_ = false;
  std::optional<Runtime> runtime_;
};

Result<void> WaitedFrames::create(Tier maxTier) {
  const Functions& vk = device_.vk;
  auto pool = tagged<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.queueFamilyIndex = device_.queueFamily;
  VkResult result = vk.CreateCommandPool(device_.handle, &pool, nullptr, &pool_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateCommandPool");
  auto buffers =
      tagged<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  buffers.commandPool = pool_;
  buffers.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffers.commandBufferCount = 1;
  result = vk.AllocateCommandBuffers(device_.handle, &buffers, &commands_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkAllocateCommandBuffers");
  const auto fence = tagged<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  result = vk.CreateFence(device_.handle, &fence, nullptr, &fence_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateFence");

  RuntimeDef def;
  def.instance = device_.instance;
  def.physicalDevice = device_.physical;
  def.device = device_.handle;
  def.queueFamily = device_.queueFamily;
  def.enabledFeatures = device_.features;
  def.getInstanceProcAddr = vk.GetInstanceProcAddr;
  def.debugUtils = own_.debugUtils();
  def.pipelineCache = own_.pipelineCache();
  def.maxTier = maxTier;
  Result<Runtime> runtime = Runtime::create(def);
  if (!runtime) return runtime.error();
  runtime_.emplace(*std::move(runtime));
  return {};
}

Result<void> WaitedFrames::begin() {
  const Functions& vk = device_.vk;
  VkResult result = vk.ResetCommandPool(device_.handle, pool_, 0);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetCommandPool");
  auto info = tagged<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  result = vk.BeginCommandBuffer(commands_, &info);
  if (result != VK_SUCCESS) return vulkanError(result, "vkBeginCommandBuffer");
  runtime_->beginFrame(frame_ + 1, frame_);
  ++frame_;
  return {};
}

Result<void> WaitedFrames::submit() {
  const Functions& vk = device_.vk;
  VkResult result = vk.EndCommandBuffer(commands_);
  if (result != VK_SUCCESS) {
    runtime_->abandonFrame();
    return vulkanError(result, "vkEndCommandBuffer");
  }
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  {
    const std::lock_guard lock(queue_.mutex);
    result = vk.QueueSubmit(queue_.handle, 1, &info, fence_);
  }
  if (result != VK_SUCCESS) {
    runtime_->abandonFrame();
    return vulkanError(result, "vkQueueSubmit");
  }
  runtime_->submitted();
  running_ = true;
  own_.busy().begin();
  result = vk.WaitForFences(device_.handle, 1, &fence_, VK_TRUE, UINT64_MAX);
  own_.busy().end();
  if (result != VK_SUCCESS) return vulkanError(result, "vkWaitForFences");
  running_ = false;
  result = vk.ResetFences(device_.handle, 1, &fence_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetFences");
  runtime_->collect(frame_);
  return {};
}

void WaitedFrames::abandon() {
  static_cast<void>(device_.vk.EndCommandBuffer(commands_));
  runtime_->abandonFrame();
  runtime_->collect(frame_);
}

class HeadlessVulkan final : public HeadlessDevice {
 public:
  HeadlessVulkan(std::shared_ptr<OwnDevice> own, Tier maxTier)
      : own_(std::move(own)), maxTier_(maxTier) {}
  ~HeadlessVulkan() override;

  /// \param own  open
  static Result<std::unique_ptr<HeadlessDevice>> make(std::shared_ptr<OwnDevice> own, Tier maxTier);

  const DeviceInfo& info() const override { return info_; }
  Result<std::unique_ptr<HeadlessDevice>> another() const override {
    return guarded([&] { return make(own_, maxTier_); });
  }
  double busySeconds() const override { return own_->busy().seconds(); }
  Result<void> update(const ResourceTable& resources) override;
  Result<TextureId> createTexture(const TextureDef& texture) override;
  Result<void> execute(const PassList& list, std::vector<PassTiming>* timings) override;
  using HeadlessDevice::render;
  Result<RenderedImage> render(std::span<const PassList* const> lists,
                               const RenderTargetDef& target,
                               std::vector<PassTiming>* timings) override;
  Result<std::vector<std::byte>> read(BufferId buffer, uint64_t offset, uint64_t size) override;
  using HeadlessDevice::supports;
  Result<void> supports(const PassList& list) const override {
    return frames_.runtime().supports(list);
  }
  void addCode(KernelCodeList code) override { frames_.runtime().addCode(code); }
  uint64_t bufferBytes() const override { return frames_.runtime().bufferBytes(); }
  uint32_t messageCount() const override { return own_->messageCount(); }

 private:
  Result<void> open();
  uint32_t sampleCounts(VkFormat color) const;
  Result<void> makeTarget(const RenderTargetDef& def);
  /// Records one list of render(): all but the first load what is there.
  Result<void> recordList(const PassList& list, const RenderTargetDef& def, const VkRect2D& area,
                          bool first);

  std::shared_ptr<OwnDevice> own_;
  Tier maxTier_;
  const Device& device_ = own_->device();
  DeviceInfo info_;
  std::unique_ptr<BufferMemory> memory_;  // of readbacks
  WaitedFrames frames_{*own_};
  std::pair<uint64_t, uint64_t> updated_ = {};  // id and version of the table
  RenderTarget target_{device_};
  std::vector<Texture> textures_;
};

HeadlessVulkan::~HeadlessVulkan() {
  // The others that share it go on.
  if (frames_.isRunning()) own_->waitIdle();
  target_.destroy();
  for (Texture& texture : textures_) texture.destroy(device_);
}

Result<std::unique_ptr<HeadlessDevice>> HeadlessVulkan::make(std::shared_ptr<OwnDevice> own,
                                                             Tier maxTier) {
  auto device = std::make_unique<HeadlessVulkan>(std::move(own), maxTier);
  if (Result<void> opened = device->open(); !opened) return opened.error();
  return std::unique_ptr<HeadlessDevice>(std::move(device));
}

Result<void> HeadlessVulkan::open() {
  if (Result<void> done = frames_.create(maxTier_); !done) return done;
  memory_ = std::make_unique<BufferMemory>(device_, BufferAllocator{});
  info_ = describe(device_);
  info_.sampleCounts = sampleCounts(RenderTarget::kColorFormat);
  info_.maxSamples = std::bit_floor(info_.sampleCounts);
  info_.tier = frames_.runtime().tier();
  return {};
}

uint32_t HeadlessVulkan::sampleCounts(VkFormat color) const {
  const auto counts = [&](VkFormat format, VkImageUsageFlags usage) -> VkSampleCountFlags {
    VkImageFormatProperties properties = {};
    const VkResult result = device_.vk.GetPhysicalDeviceImageFormatProperties(
        device_.physical, format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, usage, 0, &properties);
    return result == VK_SUCCESS ? properties.sampleCounts : 0;
  };
  const VkSampleCountFlags both =
      counts(color, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) &
      counts(RenderTarget::kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) &
      device_.limits().framebufferColorSampleCounts & device_.limits().framebufferDepthSampleCounts;
  return (both & 15u) | 1u;
}

Result<void> HeadlessVulkan::update(const ResourceTable& resources) {
  return guarded([&]() -> Result<void> {
    // Without changes there is nothing to submit and to wait for.
    const std::pair now(resources.id(), resources.version());
    if (now == updated_) return {};
    if (Result<void> done = frames_.begin(); !done) return done;
    if (Result<void> done = frames_.runtime().update(resources, frames_.commands()); !done) {
      frames_.abandon();
      return done;
    }
    Result<void> done = frames_.submit();
    if (done) updated_ = now;
    return done;
  });
}

Result<TextureId> HeadlessVulkan::createTexture(const TextureDef& def) {
  return guarded([&]() -> Result<TextureId> {
    const Result<std::vector<std::byte>> texels = textureBytes(def);
    if (!texels) return texels.error();
    textures_.reserve(textures_.size() + 1);
    Texture texture;
    if (Result<void> made = texture.make(device_, def); !made) return made.error();
    textures_.push_back(texture);
    Result<AllocatedBuffer> staging = memory_->create(
        texels->size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::kStaging, "pelage/texels");
    if (!staging) return staging.error();
    std::memcpy(staging->mapped, texels->data(), texels->size());
    Result<void> done = frames_.begin();
    if (done) {
      texture.fill(device_, frames_.commands(), staging->buffer);
      done = frames_.submit();
    }
    memory_->destroy(*staging);
    if (!done) return done.error();
    const TextureId id = newTextureId();
    frames_.runtime().registerTexture(id, texture.external());
    return id;
  });
}

Result<void> HeadlessVulkan::execute(const PassList& list, std::vector<PassTiming>* timings) {
  return guarded([&]() -> Result<void> {
    if (timings != nullptr) timings->clear();
    if (Result<void> done = frames_.begin(); !done) return done;
    frames_.runtime().setTimestamps(timings != nullptr);
    if (Result<void> done = frames_.runtime().record(list, frames_.commands()); !done) {
      frames_.abandon();
      return done;
    }
    if (Result<void> done = frames_.submit(); !done) return done;
    if (timings != nullptr) *timings = frames_.timings();
    return {};
  });
}

Result<void> HeadlessVulkan::makeTarget(const RenderTargetDef& def) {
  if (def.width < 1 || def.width > kMaxTargetSize || def.height < 1 ||
      def.height > kMaxTargetSize) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a target of {} x {} pixels; both are 1 to {}", def.width, def.height,
                             kMaxTargetSize)};
  }
  if (!std::has_single_bit(def.samples) || def.samples > 8) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} samples a pixel; they are 1, 2, 4 or 8", def.samples)};
  }
  const VkPhysicalDeviceLimits& limits = device_.limits();
  const uint32_t largest = std::min(
      {limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxFramebufferHeight});
  if (std::max(def.width, def.height) > largest) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("a target of {} x {} pixels; {} draws at most {}", def.width,
                             def.height, info_.name, largest)};
  }
  const uint32_t counts =
      def.float32Color ? sampleCounts(RenderTarget::formatOf(def)) : info_.sampleCounts;
  if ((counts & def.samples) == 0) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{} samples a pixel: {} has no such target; it has up to {}",
                             def.samples, info_.name, info_.maxSamples)};
  }
  if ((device_.queue.queueFlags & VK_QUEUE_GRAPHICS_BIT) == 0) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{} has no queue that draws; it can only compute", info_.name)};
  }
  if (target_.fits(def)) return {};
  return target_.make(def);
}

Result<void> HeadlessVulkan::recordList(const PassList& list, const RenderTargetDef& def,
                                        const VkRect2D& area, bool first) {
  if (Result<void> done = frames_.runtime().record(list, frames_.commands()); !done) return done;
  const bool draws = std::any_of(list.passes.begin(), list.passes.end(),
                                 [](const Pass& pass) { return isDraw(pass.kind); });
  if (!first && !draws) return {};
  target_.begin(frames_.commands(), def, first);
  Result<void> drawn =
      frames_.runtime().recordDraws(list, frames_.commands(), target_.formats(), area);
  device_.vk.CmdEndRenderPass(frames_.commands());
  return drawn;
}

Result<RenderedImage> HeadlessVulkan::render(std::span<const PassList* const> lists,
                                             const RenderTargetDef& def,
                                             std::vector<PassTiming>* timings) {
  return guarded([&]() -> Result<RenderedImage> {
    if (timings != nullptr) timings->clear();
    if (Result<void> made = makeTarget(def); !made) return made.error();
    const Result<PixelArea> drawn = drawArea(def);
    if (!drawn) return drawn.error();
    for (const PassList* list : lists) {
      if (Result<void> fits = checkArea(*list, *drawn); !fits) return fits.error();
    }
    const VkRect2D area = {{static_cast<int32_t>(drawn->x), static_cast<int32_t>(drawn->y)},
                           {drawn->width, drawn->height}};
    const uint64_t depthBytes = frames_.runtime().buffer(def.depthCopy).size;
    if (Result<void> ok = checkDepthCopy(def, lists.size(), depthBytes); !ok) return ok.error();
    const size_t pixelBytes = 4 * (def.float32Color ? sizeof(float) : sizeof(uint16_t));
    const size_t pixels = size_t{def.width} * def.height;
    RenderedImage image{def.width, def.height, std::vector<Float4>(pixels)};
    Result<AllocatedBuffer> readback =
        memory_->create(pixels * pixelBytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                        MemoryKind::kReadback, "pelage/readback");
    if (!readback) return readback.error();
    const auto release = [&](const Error& error) -> Result<RenderedImage> {
      memory_->destroy(*readback);
      return error;
    };

    if (Result<void> done = frames_.begin(); !done) return release(done.error());
    frames_.runtime().setTimestamps(timings != nullptr);
    const PassList none;
    const PassList* const nothing[] = {&none};
    if (lists.empty()) lists = nothing;  // still clears
    for (size_t i = 0; i < lists.size(); ++i) {
      if (Result<void> done = recordList(*lists[i], def, area, i == 0); !done) {
        frames_.abandon();
        return release(done.error());
      }
      if (def.depthCopy != BufferId::kInvalid && i == def.depthCopyAfter)
        target_.copyDepth(frames_.commands(), area, frames_.runtime().buffer(def.depthCopy));
    }
    target_.copyColor(frames_.commands(), readback->buffer);
    if (Result<void> done = frames_.submit(); !done) return release(done.error());
    if (timings != nullptr) *timings = frames_.timings();

    const auto* bytes = static_cast<const std::byte*>(readback->mapped);
    static_assert(sizeof(Float4) == 4 * sizeof(float));
    if (def.float32Color) std::memcpy(image.pixels.data(), bytes, pixels * pixelBytes);
    for (size_t i = 0; i < pixels && !def.float32Color; ++i) {
      std::array<uint16_t, 4> texel;
      std::memcpy(texel.data(), bytes + i * pixelBytes, pixelBytes);
      image.pixels[i] = {halfToFloat(texel[0]), halfToFloat(texel[1]), halfToFloat(texel[2]),
                         halfToFloat(texel[3])};
    }
    memory_->destroy(*readback);
    return image;
  });
}

Result<std::vector<std::byte>> HeadlessVulkan::read(BufferId buffer, uint64_t offset,
                                                    uint64_t size) {
  return guarded([&]() -> Result<std::vector<std::byte>> {
    const Functions& vk = device_.vk;
    const BufferRange range = frames_.runtime().buffer(buffer);
    if (range.buffer == VK_NULL_HANDLE) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("read of buffer #{}, which was removed or which update() has not "
                               "seen",
                               static_cast<uint32_t>(buffer))};
    }
    if (offset > range.size || size > range.size - offset) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("read of bytes {} to {} of a buffer of {}", offset, offset + size,
                               range.size)};
    }
    if (size == 0) size = range.size - offset;
    std::vector<std::byte> data(static_cast<size_t>(size));
    if (size == 0) return data;
    const VkDeviceSize piece = std::min(size, kMaxReadback);
    Result<AllocatedBuffer> readback = memory_->create(piece, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                                       MemoryKind::kReadback, "pelage/readback");
    if (!readback) return readback.error();
    for (VkDeviceSize at = 0; at < size; at += piece) {
      const VkDeviceSize length = std::min(piece, size - at);
      Result<void> done = frames_.begin();
      if (done) {
        auto before = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
        before.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
        before.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        vk.CmdPipelineBarrier(frames_.commands(), VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                              VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &before, 0, nullptr, 0,
                              nullptr);
        const VkBufferCopy copy = {range.offset + offset + at, 0, length};
        vk.CmdCopyBuffer(frames_.commands(), range.buffer, readback->buffer, 1, &copy);
        auto after = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
        after.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        after.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vk.CmdPipelineBarrier(frames_.commands(), VK_PIPELINE_STAGE_TRANSFER_BIT,
                              VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &after, 0, nullptr, 0, nullptr);
        done = frames_.submit();
      }
      if (!done) {
        memory_->destroy(*readback);
        return done.error();
      }
      std::memcpy(data.data() + at, readback->mapped, static_cast<size_t>(length));
    }
    memory_->destroy(*readback);
    return data;
  });
}

}  // namespace
}  // namespace vulkan

Result<std::unique_ptr<HeadlessDevice>> createHeadlessVulkan(const HeadlessDef& def) {
  return vulkan::guarded([&]() -> Result<std::unique_ptr<HeadlessDevice>> {
    if (def.api != Api::kVulkan) {
      return Error{ErrorCode::kInvalidArgument,
                   "createHeadlessVulkan() makes Vulkan devices: use createHeadlessGl()"};
    }
    auto own = std::make_shared<vulkan::OwnDevice>();
    if (Result<void> opened = own->open(def); !opened) return opened.error();
    return vulkan::HeadlessVulkan::make(std::move(own), def.maxTier);
  });
}

}  // namespace pelage
