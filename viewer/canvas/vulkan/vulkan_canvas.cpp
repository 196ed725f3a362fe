// Vulkan: two frames in flight, each with a command buffer of its own.
#include <backends/imgui_impl_vulkan.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "canvas/canvas.h"
#include "canvas/vulkan/device.h"
#include "canvas/vulkan/targets.h"
#include "pelage/list_check.h"
#include "pelage/vulkan.h"
#include "sample/code.h"
#include "viewer_kernels/code.h"
#include "window/window.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr uint32_t kFramesInFlight = 2;
constexpr const char* kCacheName = "viewer_vulkan.cache";

// A frame in flight.
struct Slot {
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
  VkSemaphore acquired = VK_NULL_HANDLE;
  uint64_t frame = 0;
  bool submitted = false;
};

// The frames in flight.
class VulkanFrames {
 public:
  explicit VulkanFrames(const VulkanDevice& device) : device_(device) {}
  ~VulkanFrames();
  VulkanFrames(const VulkanFrames&) = delete;
  VulkanFrames& operator=(const VulkanFrames&) = delete;
  Result<void> make();
  /// Begins the next frame. It waits for the earlier frame in the same slot.
  Result<void> begin();
  Slot& current() { return slots_[frame_ % kFramesInFlight]; }
  uint64_t number() const { return frame_; }
  uint64_t completed() const { return completed_; }
  Result<void> waitForAll();
  Result<void> beginCommands(Slot& slot) const;
  /// Submits the commands of a slot. \param copied is signaled at their end, and they wait for
  /// Slot::acquired; VK_NULL_HANDLE: neither.
  Result<void> submit(Slot& slot, VkSemaphore copied) const;
  /// Runs commands between two frames, and waits for them. \param name of them, for errors.
  Result<void> runAlone(const char* name, const std::function<void(VkCommandBuffer)>& record);

 private:
  Result<void> wait(Slot& slot);
  const VulkanDevice& device_;
  std::array<Slot, kFramesInFlight> slots_;
  uint64_t frame_ = 0, completed_ = 0;
};

VulkanFrames::~VulkanFrames() {
  if (device_.device == VK_NULL_HANDLE) return;
  for (const Slot& slot : slots_) {
    vkDestroySemaphore(device_.device, slot.acquired, nullptr);
    vkDestroyFence(device_.device, slot.fence, nullptr);
    vkDestroyCommandPool(device_.device, slot.pool, nullptr);
  }
}

Result<void> VulkanFrames::make() {
  for (Slot& slot : slots_) {
    auto pool = tagged<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = device_.queueFamily;
    VkResult result = vkCreateCommandPool(device_.device, &pool, nullptr, &slot.pool);
    if (result != VK_SUCCESS) return vulkanError(result, "vkCreateCommandPool");
    auto buffers =
        tagged<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    buffers.commandPool = slot.pool;
    buffers.commandBufferCount = 1;
    result = vkAllocateCommandBuffers(device_.device, &buffers, &slot.commands);
    if (result != VK_SUCCESS) return vulkanError(result, "vkAllocateCommandBuffers");
    const auto fence = tagged<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
    result = vkCreateFence(device_.device, &fence, nullptr, &slot.fence);
    if (result != VK_SUCCESS) return vulkanError(result, "vkCreateFence");
    const auto semaphore = tagged<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    result = vkCreateSemaphore(device_.device, &semaphore, nullptr, &slot.acquired);
    if (result != VK_SUCCESS) return vulkanError(result, "vkCreateSemaphore");
  }
  return {};
}

Result<void> VulkanFrames::beginCommands(Slot& slot) const {
  VkResult result = vkResetCommandPool(device_.device, slot.pool, 0);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetCommandPool");
  auto begin = tagged<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  result = vkBeginCommandBuffer(slot.commands, &begin);
  if (result != VK_SUCCESS) return vulkanError(result, "vkBeginCommandBuffer");
  return {};
}

Result<void> VulkanFrames::wait(Slot& slot) {
  if (!slot.submitted) return {};
  const VkResult result = vkWaitForFences(device_.device, 1, &slot.fence, VK_TRUE,
                                          std::numeric_limits<uint64_t>::max());
  if (result != VK_SUCCESS) return vulkanError(result, "vkWaitForFences");
  slot.submitted = false;
  completed_ = std::max(completed_, slot.frame);
  return {};
}

Result<void> VulkanFrames::waitForAll() {
  for (Slot& slot : slots_)
    if (Result<void> done = wait(slot); !done) return done;
  return {};
}

Result<void> VulkanFrames::begin() {
  if (Result<void> done = wait(slots_[(frame_ + 1) % kFramesInFlight]); !done) return done;
  ++frame_;
  current().frame = frame_;
  return {};
}

Result<void> VulkanFrames::submit(Slot& slot, VkSemaphore copied) const {
  VkResult result = vkEndCommandBuffer(slot.commands);
  if (result == VK_SUCCESS) result = vkResetFences(device_.device, 1, &slot.fence);
  if (result != VK_SUCCESS) return vulkanError(result, "vkEndCommandBuffer");
  const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &slot.commands;
  info.pWaitDstStageMask = &stage;
  if (copied != VK_NULL_HANDLE) {
    info.waitSemaphoreCount = info.signalSemaphoreCount = 1;
    info.pWaitSemaphores = &slot.acquired;
    info.pSignalSemaphores = &copied;
  }
  result = vkQueueSubmit(device_.queue, 1, &info, slot.fence);
  if (result != VK_SUCCESS) return vulkanError(result, "vkQueueSubmit");
  slot.submitted = true;
  return {};
}

Result<void> VulkanFrames::runAlone(const char* name,
                                    const std::function<void(VkCommandBuffer)>& record) {
  Slot& slot = slots_[(frame_ + 1) % kFramesInFlight];
  if (Result<void> done = beginCommands(slot); !done) return done;
  record(slot.commands);
  VkResult result = vkEndCommandBuffer(slot.commands);
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &slot.commands;
  if (result == VK_SUCCESS) result = vkQueueSubmit(device_.queue, 1, &info, VK_NULL_HANDLE);
  if (result == VK_SUCCESS) result = vkQueueWaitIdle(device_.queue);
  if (result != VK_SUCCESS) return vulkanError(result, name);
  return {};
}

// Dear ImGui on the picture.
class VulkanInterface {
 public:
  explicit VulkanInterface(const VulkanDevice& device) : device_(device) {}
  ~VulkanInterface();
  VulkanInterface(const VulkanInterface&) = delete;
  VulkanInterface& operator=(const VulkanInterface&) = delete;
  /// \param picture the render pass that it is drawn in.
  Result<void> make(VkRenderPass picture, VulkanFrames& frames);

 private:
  const VulkanDevice& device_;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  bool isMade_ = false;
};

VulkanInterface::~VulkanInterface() {
  if (isMade_) ImGui_ImplVulkan_Shutdown();
  if (pool_ != VK_NULL_HANDLE) vkDestroyDescriptorPool(device_.device, pool_, nullptr);
}

Result<void> VulkanInterface::make(VkRenderPass picture, VulkanFrames& frames) {
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 8};
  auto pool = tagged<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
  pool.maxSets = size.descriptorCount;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  const VkResult made = vkCreateDescriptorPool(device_.device, &pool, nullptr, &pool_);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateDescriptorPool");
  ImGui_ImplVulkan_InitInfo info = {};
  info.Instance = device_.instance;
  info.PhysicalDevice = device_.physical;
  info.Device = device_.device;
  info.QueueFamily = device_.queueFamily;
  info.Queue = device_.queue;
  info.DescriptorPool = pool_;
  info.MinImageCount = kFramesInFlight;
  info.ImageCount = kFramesInFlight;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  isMade_ = ImGui_ImplVulkan_Init(&info, picture);
  if (!isMade_) return Error{ErrorCode::kDevice, "the user interface cannot be drawn with Vulkan"};
  Result<void> uploaded = frames.runAlone("uploading the font", [](VkCommandBuffer commands) {
    ImGui_ImplVulkan_CreateFontsTexture(commands);
  });
  ImGui_ImplVulkan_DestroyFontUploadObjects();
  return uploaded;
}

Result<void> makeRuntime(std::span<const std::byte> cache, pelage::KernelCodeList code,
                         VulkanDevice& device, std::optional<pelage::vulkan::Runtime>& made) {
  pelage::vulkan::RuntimeDef def;
  // The first table with a permutation is used.
  if (!code.empty()) def.code.insert(def.code.begin(), code);
  def.instance = device.instance;
  def.physicalDevice = device.physical;
  def.device = device.device;
  def.queueFamily = device.queueFamily;
  def.enabledFeatures = device.features;
  def.getInstanceProcAddr = vkGetInstanceProcAddr;
  def.pipelineCacheData = cache;
  def.debugUtils = device.debugUtils;
  Result<pelage::vulkan::Runtime> runtime = pelage::vulkan::Runtime::create(def);
  if (!runtime) return runtime.error();
  made.emplace(*std::move(runtime));
  made->addCode(sample::allCode());
  made->addCode(viewer_kernels::allCode());
  made->setTimestamps(true);
  device.info.tier = made->tier();
  return {};
}

// Makes the writes of earlier commands visible to later ones.
void waitForWrites(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written,
                   VkPipelineStageFlags to, VkAccessFlags read) {
  auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = written;
  barrier.dstAccessMask = read;
  vkCmdPipelineBarrier(commands, from, to, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

void waitForCopy(VkCommandBuffer commands) {
  waitForWrites(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
}

class VulkanCanvas final : public Canvas {
 public:
  explicit VulkanCanvas(CanvasDef def) : def_(std::move(def)) {}
  ~VulkanCanvas() override;
  Result<void> open(Window& window);

  const pelage::DeviceInfo& info() const override { return device_.info; }
  Result<void> supports(const pelage::TransparencySettings& settings) const override;
  Result<void> setCode(pelage::KernelCodeList code) override;
  Result<void> setTarget(const CanvasTarget& target) override;
  Result<void> begin() override;
  Result<void> show(const CanvasFrame& frame) override;
  Result<std::vector<std::byte>> read(pelage::BufferId buffer) override;
  CanvasMemory memory() const override {
    const pelage::vulkan::MemoryUse use = runtime_->memoryUse();
    return {use.bufferBytes, use.frameBytes};
  }
  uint32_t messageCount() const override { return device_.messages.load(); }
  void saveCache() override;

 private:
  Result<void> record(const CanvasFrame& frame, Slot& slot);
  void takePicture();

  CanvasDef def_;
  VulkanDevice device_;
  VulkanTargets targets_{device_};
  VulkanSwapchain swapchain_{device_};
  VulkanFrames frames_{device_};
  VulkanReadback readback_{device_};  // of the picture
  std::optional<pelage::vulkan::Runtime> runtime_;
  VulkanInterface interface_{device_};
  pelage::TextureId scene_ = pelage::newTextureId();
  CanvasTarget target_;  // without a size: there is none
};

VulkanCanvas::~VulkanCanvas() {
  if (device_.device != VK_NULL_HANDLE) static_cast<void>(vkDeviceWaitIdle(device_.device));
}

Result<void> VulkanCanvas::open(Window& window) {
  if (Result<void> done = device_.open(def_, window); !done) return done;
  if (Result<void> done = swapchain_.chooseFormat(); !done) return done;
  if (Result<void> done = targets_.makePasses(swapchain_.format()); !done) return done;
  if (Result<void> done = frames_.make(); !done) return done;
  const std::vector<std::byte> cache =
      def_.cache.empty() ? std::vector<std::byte>() : readCache(def_.cache / kCacheName);
  if (Result<void> done = makeRuntime(cache, {}, device_, runtime_); !done) return done;
  return interface_.make(targets_.picturePass(), frames_);
}

Result<void> VulkanCanvas::supports(const pelage::TransparencySettings& settings) const {
  return runtime_->supports(settings, {.followHairs = true});
}

Result<void> VulkanCanvas::setCode(pelage::KernelCodeList code) {
  if (Result<void> done = frames_.waitForAll(); !done) return done;
  const VkResult idle = vkDeviceWaitIdle(device_.device);
  if (idle != VK_SUCCESS) return vulkanError(idle, "vkDeviceWaitIdle");
  // Unchanged kernels are not compiled again.
  const Result<std::vector<std::byte>> cache = runtime_->pipelineCacheData();
  runtime_.reset();
  timings_.clear();
  Result<void> made =
      makeRuntime(cache ? *cache : std::vector<std::byte>(), code, device_, runtime_);
  if (made && target_.width > 0) runtime_->registerTexture(scene_, {.view = targets_.sceneView()});
  return made;
}

Result<void> VulkanCanvas::setTarget(const CanvasTarget& target) {
  if (target == target_ && !swapchain_.isStale()) return {};
  if (Result<void> can = checkSamples(device_.info, target.samples); !can) return can;
  VkResult result = vkDeviceWaitIdle(device_.device);
  if (result != VK_SUCCESS) return vulkanError(result, "vkDeviceWaitIdle");
  const bool resized = target.width != target_.width || target.height != target_.height;
  if (!(target == target_)) {
    target_ = {};
    if (Result<void> done = targets_.make(target); !done) return done;
    runtime_->registerTexture(scene_, {.view = targets_.sceneView()});
    readback_.release();
  }
  if (resized || swapchain_.isStale())
    if (Result<void> done = swapchain_.make(target.width, target.height, def_.vsync); !done)
      return done;
  target_ = target;
  return {};
}

Result<void> VulkanCanvas::begin() {
  if (Result<void> done = frames_.begin(); !done) return done;
  const uint64_t completed = frames_.completed();
  runtime_->beginFrame(frames_.number(), completed);
  if (completed > 0) timings_ = runtime_->timings(completed);
  ImGui_ImplVulkan_NewFrame();
  return {};
}

// Records the scene's views, then the picture with the interface.
Result<void> VulkanCanvas::record(const CanvasFrame& frame, Slot& slot) {
  const uint32_t views = frame.frame->viewCount();
  Result<pelage::PassList> picture =
      pictureList(scene_, target_.width, target_.height, false, frame.coarseness);
  if (!picture) return picture.error();
  if (const auto added = frame.frame->addView(*std::move(picture)); !added) return added.error();
  if (Result<void> done = frames_.beginCommands(slot); !done) return done;
  std::vector<pelage::vulkan::ViewTarget> targets(views + 1);
  for (uint32_t view = 0; view < views; ++view) {
    targets[view].formats = targets_.sceneFormats();
    const CanvasView& on = frame.views[view];
    const VkRect2D area = {{static_cast<int32_t>(on.area.x), static_cast<int32_t>(on.area.y)},
                           {on.area.width, on.area.height}};
    targets[view].area = area;
    targets[view].begin = [this, &slot, view](const pelage::FrameStep& step) {
      targets_.beginScene(slot.commands, view == 0 && step.listOfView == 0);
    };
    targets[view].end = [this, &slot, area,
                         depthCopy = on.depthCopy](const pelage::FrameStep& step) {
      vkCmdEndRenderPass(slot.commands);
      if (step.listOfView == 0 && depthCopy != pelage::BufferId::kInvalid)
        targets_.copyDepth(slot.commands, area, runtime_->buffer(depthCopy));
    };
  }
  targets[views].formats = targets_.pictureFormats();
  targets[views].area = targets_.area();
  targets[views].begin = [this, &slot](const pelage::FrameStep&) {
    targets_.beginPicture(slot.commands);
  };
  targets[views].end = [&slot, &frame](const pelage::FrameStep&) {
    if (frame.interface != nullptr) ImGui_ImplVulkan_RenderDrawData(frame.interface, slot.commands);
    vkCmdEndRenderPass(slot.commands);
  };
  return runtime_->record(*frame.frame, slot.commands, targets);
}

Result<void> VulkanCanvas::show(const CanvasFrame& frame) {
  Slot& slot = frames_.current();
  if (frame.captures && readback_.buffer() == VK_NULL_HANDLE)
    if (Result<void> made = readback_.make(VkDeviceSize{4} * target_.width * target_.height); !made)
      return made;
  if (Result<void> done = record(frame, slot); !done) {
    static_cast<void>(vkEndCommandBuffer(slot.commands));
    runtime_->abandonFrame();
    return done;
  }
  if (frame.captures) {
    VkBufferImageCopy copy = {};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {target_.width, target_.height, 1};
    vkCmdCopyImageToBuffer(slot.commands, targets_.picture(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           readback_.buffer(), 1, &copy);
    waitForCopy(slot.commands);
  }
  const std::optional<uint32_t> image = swapchain_.acquire(slot.acquired);
  if (image)
    swapchain_.copy(slot.commands, targets_.picture(), {target_.width, target_.height}, *image);
  const VkSemaphore copied = image ? swapchain_.copied(*image) : VK_NULL_HANDLE;
  if (Result<void> done = frames_.submit(slot, copied); !done) {
    runtime_->abandonFrame();
    return done;
  }
  runtime_->submitted();
  if (image)
    if (Result<void> done = swapchain_.present(*image); !done) return done;
  if (!frame.captures) return {};
  if (Result<void> done = frames_.waitForAll(); !done) return done;
  takePicture();
  return {};
}

void VulkanCanvas::takePicture() {
  captured_.width = target_.width;
  captured_.height = target_.height;
  captured_.rgb.resize(size_t{3} * target_.width * target_.height);
  const auto* from = static_cast<const uint8_t*>(readback_.mapped());
  const bool bgr = swapchain_.format() == VK_FORMAT_B8G8R8A8_UNORM;
  for (size_t i = 0; i < size_t{target_.width} * target_.height; ++i)
    for (size_t channel = 0; channel < 3; ++channel)
      captured_.rgb[3 * i + channel] = from[4 * i + (bgr ? 2 - channel : channel)];
}

Result<std::vector<std::byte>> VulkanCanvas::read(pelage::BufferId buffer) {
  const pelage::vulkan::BufferRange range = runtime_->buffer(buffer);
  if (range.buffer == VK_NULL_HANDLE)
    return Error{ErrorCode::kInvalidArgument, "a buffer that is read back is not there"};
  if (Result<void> done = frames_.waitForAll(); !done) return done.error();
  VulkanReadback readback(device_);
  if (Result<void> made = readback.make(range.size); !made) return made.error();
  Result<void> done = frames_.runAlone("reading a buffer back", [&](VkCommandBuffer commands) {
    waitForWrites(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_WRITE_BIT,
                  VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
    const VkBufferCopy copy = {range.offset, 0, range.size};
    vkCmdCopyBuffer(commands, range.buffer, readback.buffer(), 1, &copy);
    waitForCopy(commands);
  });
  if (!done) return done.error();
  std::vector<std::byte> bytes(static_cast<size_t>(range.size));
  std::memcpy(bytes.data(), readback.mapped(), bytes.size());
  return bytes;
}

void VulkanCanvas::saveCache() {
  if (def_.cache.empty()) return;
  const Result<std::vector<std::byte>> data = runtime_->pipelineCacheData();
  if (data) writeCache(def_.cache / kCacheName, *data);
}

}  // namespace

Result<std::unique_ptr<Canvas>> createVulkanCanvas(const CanvasDef& def, Window& window) {
  auto canvas = std::make_unique<VulkanCanvas>(def);
  if (Result<void> opened = canvas->open(window); !opened) return opened.error();
  return std::unique_ptr<Canvas>(std::move(canvas));
}

}  // namespace viewer
