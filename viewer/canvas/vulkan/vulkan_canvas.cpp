// Vulkan: two frames in flight, each with a command buffer of its own.
#include <backends/imgui_impl_vulkan.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "canvas/cache_file.h"
#include "canvas/canvas.h"
#include "canvas/picture.h"
#include "canvas/vulkan/device.h"
#include "canvas/vulkan/swapchain.h"
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

// What a frame in flight owns.
struct Slot {
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
  VkSemaphore acquired = VK_NULL_HANDLE;
  uint64_t frame = 0;
  bool submitted = false;
};

class VulkanCanvas final : public Canvas {
 public:
  explicit VulkanCanvas(CanvasDef def) : def_(std::move(def)) {}
  ~VulkanCanvas() override;
  Result<void> open(Window& window);

  const pelage::DeviceInfo& info() const override { return device_.info; }
  Result<void> supports(const pelage::TransparencySettings& settings) const override {
    return runtime_->supports(settings, {.followHairs = true});
  }
  Result<void> setCode(pelage::KernelCodeList code) override;
  Result<void> setTarget(const CanvasTarget& target) override;
  Result<void> begin() override;
  Result<void> show(const CanvasFrame& frame) override;
  const sample::ByteImage& captured() const override { return captured_; }
  Result<std::vector<std::byte>> read(pelage::BufferId buffer) override;
  const std::vector<pelage::PassTiming>& timings() const override { return timings_; }
  CanvasMemory memory() const override {
    const pelage::vulkan::MemoryUse use = runtime_->memoryUse();
    return {use.bufferBytes, use.frameBytes};
  }
  uint32_t messageCount() const override { return device_.messages.load(); }
  void saveCache() override;

 private:
  Result<void> makeSlots();
  Result<void> makeRuntime(std::span<const std::byte> cache, pelage::KernelCodeList code);
  Result<void> makeInterface();
  Result<void> uploadFonts();
  Result<void> beginCommands(Slot& slot) const;
  Result<void> wait(Slot& slot);
  Result<void> record(const CanvasFrame& frame, Slot& slot);
  std::optional<uint32_t> acquire(const Slot& slot);
  void copyToWindow(VkCommandBuffer commands, uint32_t image) const;
  Result<void> submit(Slot& slot, std::optional<uint32_t> image);
  void takePicture();

  CanvasDef def_;
  VulkanDevice device_;
  VulkanTargets targets_{device_};
  VulkanSwapchain swapchain_{device_};
  std::array<Slot, kFramesInFlight> slots_;
  std::optional<pelage::vulkan::Runtime> runtime_;
  pelage::TextureId scene_ = pelage::newTextureId();
  VkDescriptorPool interfacePool_ = VK_NULL_HANDLE;
  bool hasInterface_ = false;
  uint64_t frame_ = 0, completed_ = 0;
  CanvasTarget target_;  // without a size: there is none
  bool stale_ = false;   // the swapchain does not fit the window any more
  VulkanReadback readback_;
  sample::ByteImage captured_;
  std::vector<pelage::PassTiming> timings_;
};

VulkanCanvas::~VulkanCanvas() {
  if (device_.device == VK_NULL_HANDLE) return;
  static_cast<void>(vkDeviceWaitIdle(device_.device));
  if (hasInterface_) ImGui_ImplVulkan_Shutdown();
  vkDestroyDescriptorPool(device_.device, interfacePool_, nullptr);
  runtime_.reset();
  destroyReadback(device_, readback_);
  for (const Slot& slot : slots_) {
    vkDestroySemaphore(device_.device, slot.acquired, nullptr);
    vkDestroyFence(device_.device, slot.fence, nullptr);
    vkDestroyCommandPool(device_.device, slot.pool, nullptr);
  }
}

Result<void> VulkanCanvas::open(Window& window) {
  if (Result<void> done = device_.open(def_, window); !done) return done;
  if (Result<void> done = swapchain_.chooseFormat(); !done) return done;
  if (Result<void> done = targets_.makePasses(swapchain_.format()); !done) return done;
  if (Result<void> done = makeSlots(); !done) return done;
  const std::vector<std::byte> cache =
      def_.cache.empty() ? std::vector<std::byte>() : readCache(def_.cache / kCacheName);
  if (Result<void> done = makeRuntime(cache, {}); !done) return done;
  return makeInterface();
}

Result<void> VulkanCanvas::makeSlots() {
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

Result<void> VulkanCanvas::makeRuntime(std::span<const std::byte> cache,
                                       pelage::KernelCodeList code) {
  pelage::vulkan::RuntimeDef def;
  // The first table that has a permutation counts.
  if (!code.empty()) def.code.insert(def.code.begin(), code);
  def.instance = device_.instance;
  def.physicalDevice = device_.physical;
  def.device = device_.device;
  def.queueFamily = device_.queueFamily;
  def.enabledFeatures = device_.features;
  def.getInstanceProcAddr = vkGetInstanceProcAddr;
  def.pipelineCacheData = cache;
  def.debugUtils = device_.debugUtils;
  Result<pelage::vulkan::Runtime> runtime = pelage::vulkan::Runtime::create(def);
  if (!runtime) return runtime.error();
  runtime_.emplace(*std::move(runtime));
  runtime_->addCode(sample::allCode());
  runtime_->addCode(viewer_kernels::allCode());
  runtime_->setTimestamps(true);
  device_.info.tier = runtime_->tier();
  return {};
}

Result<void> VulkanCanvas::setCode(pelage::KernelCodeList code) {
  for (Slot& slot : slots_)
    if (Result<void> done = wait(slot); !done) return done;
  const VkResult idle = vkDeviceWaitIdle(device_.device);
  if (idle != VK_SUCCESS) return vulkanError(idle, "vkDeviceWaitIdle");
  // What has not changed need not be compiled again.
  const Result<std::vector<std::byte>> cache = runtime_->pipelineCacheData();
  runtime_.reset();
  timings_.clear();
  Result<void> made = makeRuntime(cache ? *cache : std::vector<std::byte>(), code);
  if (made && target_.width > 0) runtime_->registerTexture(scene_, {.view = targets_.sceneView()});
  return made;
}

Result<void> VulkanCanvas::makeInterface() {
  const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 8};
  auto pool = tagged<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
  pool.maxSets = size.descriptorCount;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  const VkResult made = vkCreateDescriptorPool(device_.device, &pool, nullptr, &interfacePool_);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateDescriptorPool");
  ImGui_ImplVulkan_InitInfo info = {};
  info.Instance = device_.instance;
  info.PhysicalDevice = device_.physical;
  info.Device = device_.device;
  info.QueueFamily = device_.queueFamily;
  info.Queue = device_.queue;
  info.DescriptorPool = interfacePool_;
  info.MinImageCount = kFramesInFlight;
  info.ImageCount = kFramesInFlight;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  hasInterface_ = ImGui_ImplVulkan_Init(&info, targets_.picturePass());
  if (!hasInterface_)
    return Error{ErrorCode::kDevice, "the user interface cannot be drawn with Vulkan"};
  return uploadFonts();
}

Result<void> VulkanCanvas::uploadFonts() {
  Slot& slot = slots_[0];
  if (Result<void> done = beginCommands(slot); !done) return done;
  ImGui_ImplVulkan_CreateFontsTexture(slot.commands);
  VkResult result = vkEndCommandBuffer(slot.commands);
  auto submit = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &slot.commands;
  if (result == VK_SUCCESS) result = vkQueueSubmit(device_.queue, 1, &submit, VK_NULL_HANDLE);
  if (result == VK_SUCCESS) result = vkQueueWaitIdle(device_.queue);
  ImGui_ImplVulkan_DestroyFontUploadObjects();
  if (result != VK_SUCCESS) return vulkanError(result, "uploading the font");
  return {};
}

Result<void> VulkanCanvas::setTarget(const CanvasTarget& target) {
  if (target == target_ && !stale_) return {};
  if (Result<void> can = checkSamples(device_.info, target.samples); !can) return can;
  VkResult result = vkDeviceWaitIdle(device_.device);
  if (result != VK_SUCCESS) return vulkanError(result, "vkDeviceWaitIdle");
  const bool resized = target.width != target_.width || target.height != target_.height;
  if (!(target == target_)) {
    target_ = {};
    if (Result<void> done = targets_.make(target); !done) return done;
    runtime_->registerTexture(scene_, {.view = targets_.sceneView()});
    destroyReadback(device_, readback_);
  }
  if (resized || stale_)
    if (Result<void> done = swapchain_.make(target.width, target.height, def_.vsync); !done)
      return done;
  target_ = target;
  stale_ = false;
  return {};
}

Result<void> VulkanCanvas::beginCommands(Slot& slot) const {
  VkResult result = vkResetCommandPool(device_.device, slot.pool, 0);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetCommandPool");
  auto begin = tagged<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  result = vkBeginCommandBuffer(slot.commands, &begin);
  if (result != VK_SUCCESS) return vulkanError(result, "vkBeginCommandBuffer");
  return {};
}

Result<void> VulkanCanvas::wait(Slot& slot) {
  if (!slot.submitted) return {};
  const VkResult result = vkWaitForFences(device_.device, 1, &slot.fence, VK_TRUE,
                                          std::numeric_limits<uint64_t>::max());
  if (result != VK_SUCCESS) return vulkanError(result, "vkWaitForFences");
  slot.submitted = false;
  completed_ = std::max(completed_, slot.frame);
  return {};
}

Result<void> VulkanCanvas::begin() {
  Slot& slot = slots_[(frame_ + 1) % kFramesInFlight];
  if (Result<void> done = wait(slot); !done) return done;
  slot.frame = ++frame_;
  runtime_->beginFrame(frame_, completed_);
  if (completed_ > 0) timings_ = runtime_->timings(completed_);
  ImGui_ImplVulkan_NewFrame();
  return {};
}

// The scene's views, then the picture with the interface on it.
Result<void> VulkanCanvas::record(const CanvasFrame& frame, Slot& slot) {
  const uint32_t views = frame.frame->viewCount();
  Result<pelage::PassList> picture = pictureList(scene_, target_.width, target_.height, false);
  if (!picture) return picture.error();
  if (const auto added = frame.frame->addView(*std::move(picture)); !added) return added.error();
  if (Result<void> done = beginCommands(slot); !done) return done;
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

// An image of the window, where there is one: a frame without it still runs.
std::optional<uint32_t> VulkanCanvas::acquire(const Slot& slot) {
  if (swapchain_.extent().width == 0) return std::nullopt;
  uint32_t image = 0;
  const VkResult result = vkAcquireNextImageKHR(device_.device, swapchain_.handle(),
                                                std::numeric_limits<uint64_t>::max(), slot.acquired,
                                                VK_NULL_HANDLE, &image);
  stale_ |= result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
  if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) return std::nullopt;
  return image;
}

void VulkanCanvas::copyToWindow(VkCommandBuffer commands, uint32_t image) const {
  auto barrier = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
  barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = swapchain_.image(image);
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                       0, nullptr, 0, nullptr, 1, &barrier);
  VkImageCopy copy = {};
  copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.extent = {std::min(target_.width, swapchain_.extent().width),
                 std::min(target_.height, swapchain_.extent().height), 1};
  vkCmdCopyImage(commands, targets_.picture(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, barrier.image,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = 0;
  barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.newLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 0, nullptr, 0, nullptr, 1,
                       &barrier);
}

Result<void> VulkanCanvas::submit(Slot& slot, std::optional<uint32_t> image) {
  VkResult result = vkEndCommandBuffer(slot.commands);
  if (result == VK_SUCCESS) result = vkResetFences(device_.device, 1, &slot.fence);
  if (result != VK_SUCCESS) return vulkanError(result, "vkEndCommandBuffer");
  const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &slot.commands;
  info.pWaitDstStageMask = &stage;
  VkSemaphore copied = VK_NULL_HANDLE;
  if (image) {
    copied = swapchain_.copied(*image);
    info.waitSemaphoreCount = info.signalSemaphoreCount = 1;
    info.pWaitSemaphores = &slot.acquired;
    info.pSignalSemaphores = &copied;
  }
  result = vkQueueSubmit(device_.queue, 1, &info, slot.fence);
  if (result != VK_SUCCESS) return vulkanError(result, "vkQueueSubmit");
  slot.submitted = true;
  runtime_->submitted();
  if (!image) return {};
  const VkSwapchainKHR swapchain = swapchain_.handle();
  auto present = tagged<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
  present.waitSemaphoreCount = 1;
  present.pWaitSemaphores = &copied;
  present.swapchainCount = 1;
  present.pSwapchains = &swapchain;
  present.pImageIndices = &*image;
  result = vkQueuePresentKHR(device_.queue, &present);
  stale_ |= result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
  if (result == VK_ERROR_DEVICE_LOST || result == VK_ERROR_SURFACE_LOST_KHR)
    return vulkanError(result, "vkQueuePresentKHR");
  return {};
}

Result<void> VulkanCanvas::show(const CanvasFrame& frame) {
  Slot& slot = slots_[frame_ % kFramesInFlight];
  if (frame.captures && readback_.buffer == VK_NULL_HANDLE) {
    Result<VulkanReadback> made =
        makeReadback(device_, VkDeviceSize{4} * target_.width * target_.height);
    if (!made) return made.error();
    readback_ = *made;
  }
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
                           readback_.buffer, 1, &copy);
    auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(slot.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                         0, 1, &barrier, 0, nullptr, 0, nullptr);
  }
  const std::optional<uint32_t> image = acquire(slot);
  if (image) copyToWindow(slot.commands, *image);
  if (Result<void> done = submit(slot, image); !done) {
    if (!slot.submitted) runtime_->abandonFrame();
    return done;
  }
  if (!frame.captures) return {};
  if (Result<void> done = wait(slot); !done) return done;
  takePicture();
  return {};
}

void VulkanCanvas::takePicture() {
  captured_.width = target_.width;
  captured_.height = target_.height;
  captured_.rgb.resize(size_t{3} * target_.width * target_.height);
  const auto* from = static_cast<const uint8_t*>(readback_.mapped);
  const bool bgr = swapchain_.format() == VK_FORMAT_B8G8R8A8_UNORM;
  for (size_t i = 0; i < size_t{target_.width} * target_.height; ++i)
    for (size_t channel = 0; channel < 3; ++channel)
      captured_.rgb[3 * i + channel] = from[4 * i + (bgr ? 2 - channel : channel)];
}

Result<std::vector<std::byte>> VulkanCanvas::read(pelage::BufferId buffer) {
  const pelage::vulkan::BufferRange range = runtime_->buffer(buffer);
  if (range.buffer == VK_NULL_HANDLE)
    return Error{ErrorCode::kInvalidArgument, "a buffer that is read back is not there"};
  for (Slot& slot : slots_)
    if (Result<void> done = wait(slot); !done) return done.error();
  Result<VulkanReadback> made = makeReadback(device_, range.size);
  if (!made) return made.error();
  VulkanReadback readback = *made;
  Slot& slot = slots_[(frame_ + 1) % kFramesInFlight];
  Result<void> begun = beginCommands(slot);
  if (!begun) {
    destroyReadback(device_, readback);
    return begun.error();
  }
  auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  vkCmdPipelineBarrier(slot.commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
  const VkBufferCopy copy = {range.offset, 0, range.size};
  vkCmdCopyBuffer(slot.commands, range.buffer, readback.buffer, 1, &copy);
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(slot.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0,
                       1, &barrier, 0, nullptr, 0, nullptr);
  VkResult result = vkEndCommandBuffer(slot.commands);
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &slot.commands;
  if (result == VK_SUCCESS) result = vkQueueSubmit(device_.queue, 1, &info, VK_NULL_HANDLE);
  if (result == VK_SUCCESS) result = vkQueueWaitIdle(device_.queue);
  std::vector<std::byte> bytes(static_cast<size_t>(range.size));
  if (result == VK_SUCCESS) std::memcpy(bytes.data(), readback.mapped, bytes.size());
  destroyReadback(device_, readback);
  if (result != VK_SUCCESS) return vulkanError(result, "reading a buffer back");
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
