#include "canvas/vulkan/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr VkPipelineStageFlags kAttachmentStages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                                   VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                                   VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
constexpr VkAccessFlags kAttachmentAccess =
    VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;

VkAttachmentDescription attachment(VkFormat format, uint32_t samples, VkAttachmentLoadOp load,
                                   VkImageLayout from, VkImageLayout to) {
  VkAttachmentDescription description = {};
  description.format = format;
  description.samples = static_cast<VkSampleCountFlagBits>(samples);
  description.loadOp = load;
  description.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  description.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  description.initialLayout = from;
  description.finalLayout = to;
  return description;
}

VkSubpassDependency dependency(VkPipelineStageFlags from, VkAccessFlags written,
                               VkPipelineStageFlags to, VkAccessFlags used) {
  VkSubpassDependency dependency = {};
  dependency.srcStageMask = from;
  dependency.srcAccessMask = written;
  dependency.dstStageMask = to;
  dependency.dstAccessMask = used;
  return dependency;
}

// A render pass with a dependency before it and one after it.
Result<VkRenderPass> makePass(const VulkanDevice& device,
                              std::span<const VkAttachmentDescription> attachments,
                              const VkSubpassDescription& subpass, VkSubpassDependency before,
                              VkSubpassDependency after) {
  before.srcSubpass = after.dstSubpass = VK_SUBPASS_EXTERNAL;
  const VkSubpassDependency dependencies[] = {before, after};
  auto info = tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
  info.attachmentCount = static_cast<uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<uint32_t>(std::size(dependencies));
  info.pDependencies = dependencies;
  VkRenderPass pass = VK_NULL_HANDLE;
  const VkResult made = vkCreateRenderPass(device.device, &info, nullptr, &pass);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateRenderPass");
  return pass;
}

// Between its render passes the color can be sampled, and the depth keeps its layout; so do the
// samples, whose mean is the color.
Result<VkRenderPass> scenePass(const VulkanDevice& device, uint32_t samples, bool clears) {
  const VkAttachmentLoadOp load = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  const auto before = [&](VkImageLayout layout) {
    return clears ? VK_IMAGE_LAYOUT_UNDEFINED : layout;
  };
  constexpr VkImageLayout kReadLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  constexpr VkImageLayout kDepthLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  constexpr VkImageLayout kColorLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  const VkImageLayout drawn = samples > 1 ? kColorLayout : kReadLayout;
  const VkAttachmentDescription attachments[] = {
      attachment(VulkanTargets::kSceneFormat, samples, load, before(drawn), drawn),
      attachment(VulkanTargets::kDepthFormat, samples, load, before(kDepthLayout), kDepthLayout),
      attachment(VulkanTargets::kSceneFormat, 1, VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                 VK_IMAGE_LAYOUT_UNDEFINED, kReadLayout)};
  const VkAttachmentReference color = {0, kColorLayout};
  const VkAttachmentReference depth = {1, kDepthLayout};
  const VkAttachmentReference resolved = {2, kColorLayout};
  VkSubpassDescription subpass = {};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &color;
  subpass.pResolveAttachments = samples > 1 ? &resolved : nullptr;
  subpass.pDepthStencilAttachment = &depth;
  constexpr VkPipelineStageFlags kSampled = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
  return makePass(device, std::span(attachments).first(samples > 1 ? 3 : 2), subpass,
                  dependency(kAttachmentStages | kSampled, kAttachmentAccess, kAttachmentStages,
                             kAttachmentAccess),
                  dependency(kAttachmentStages, kAttachmentAccess, kAttachmentStages | kSampled,
                             kAttachmentAccess | VK_ACCESS_SHADER_READ_BIT));
}

Result<void> makeScenePasses(const VulkanDevice& device, uint32_t samples, ScenePasses& passes) {
  for (VkRenderPass* pass : {&passes.clear, &passes.load}) {
    if (*pass != VK_NULL_HANDLE) continue;
    Result<VkRenderPass> made = scenePass(device, samples, pass == &passes.clear);
    if (!made) return made.error();
    *pass = *made;
  }
  return {};
}

struct ImageDef {
  VkFormat format;
  VkImageUsageFlags usage;
  VkImageAspectFlags aspect;
  VkImageViewType type;
  uint32_t samples;
};

Result<void> makeImage(const VulkanDevice& device, const CanvasTarget& target, const ImageDef& def,
                       VulkanImage& image) {
  const auto fail = [&](VkResult result) {
    return vulkanError(result, fmt::format("a target of {} x {} pixels with {} samples each",
                                           target.width, target.height, def.samples));
  };
  auto info = tagged<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = def.format;
  info.extent = {target.width, target.height, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = static_cast<VkSampleCountFlagBits>(def.samples);
  info.usage = def.usage;
  VkResult result = vkCreateImage(device.device, &info, nullptr, &image.image);
  if (result != VK_SUCCESS) return fail(result);
  VkMemoryRequirements needs = {};
  vkGetImageMemoryRequirements(device.device, image.image, &needs);
  result = device.allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, image.memory);
  if (result == VK_SUCCESS) result = vkBindImageMemory(device.device, image.image, image.memory, 0);
  if (result != VK_SUCCESS) return fail(result);
  auto view = tagged<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = image.image;
  view.viewType = def.type;
  view.format = def.format;
  view.subresourceRange = {def.aspect, 0, 1, 0, 1};
  result = vkCreateImageView(device.device, &view, nullptr, &image.view);
  if (result != VK_SUCCESS) return fail(result);
  return {};
}

Result<VkFramebuffer> makeFramebuffer(const VulkanDevice& device, const CanvasTarget& target,
                                      VkRenderPass pass, std::span<const VkImageView> views) {
  auto info = tagged<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
  info.renderPass = pass;
  info.attachmentCount = static_cast<uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = target.width;
  info.height = target.height;
  info.layers = 1;
  VkFramebuffer frame = VK_NULL_HANDLE;
  const VkResult made = vkCreateFramebuffer(device.device, &info, nullptr, &frame);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateFramebuffer");
  return frame;
}

VkImageMemoryBarrier barrierOf(VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                               VkImageLayout to) {
  auto barrier = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {aspect, 0, 1, 0, 1};
  return barrier;
}

}  // namespace

Result<void> VulkanReadback::make(VkDeviceSize size) {
  auto info = tagged<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkResult result = vkCreateBuffer(device_.device, &info, nullptr, &buffer_);
  if (result == VK_SUCCESS) {
    VkMemoryRequirements needs = {};
    vkGetBufferMemoryRequirements(device_.device, buffer_, &needs);
    result = device_.allocate(
        needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, memory_);
  }
  if (result == VK_SUCCESS) result = vkBindBufferMemory(device_.device, buffer_, memory_, 0);
  if (result == VK_SUCCESS)
    result = vkMapMemory(device_.device, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_);
  if (result == VK_SUCCESS) return {};
  release();
  return vulkanError(result, fmt::format("a buffer of {} bytes to read back", size));
}

void VulkanReadback::release() {
  // The loader ends the program where it gets no device.
  if (device_.device == VK_NULL_HANDLE) return;
  vkDestroyBuffer(device_.device, buffer_, nullptr);
  vkFreeMemory(device_.device, memory_, nullptr);
  buffer_ = VK_NULL_HANDLE;
  memory_ = VK_NULL_HANDLE;
  mapped_ = nullptr;
}

VulkanTargets::~VulkanTargets() {
  // The loader ends the program where it gets no device.
  if (device_.device == VK_NULL_HANDLE) return;
  destroyImages();
  for (const auto& [samples, passes] : scenePasses_)
    for (const VkRenderPass pass : {passes.clear, passes.load})
      vkDestroyRenderPass(device_.device, pass, nullptr);
  vkDestroyRenderPass(device_.device, picturePass_, nullptr);
}

Result<void> VulkanTargets::makePasses(VkFormat picture) {
  pictureFormat_ = picture;
  // The draw covers the whole picture, which is copied afterwards.
  const VkAttachmentDescription color =
      attachment(picture, 1, VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
                 VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const VkAttachmentReference reference = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass = {};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  constexpr VkPipelineStageFlags kDrawn = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  constexpr VkPipelineStageFlags kCopied = VK_PIPELINE_STAGE_TRANSFER_BIT;
  constexpr VkAccessFlags kWritten = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  Result<VkRenderPass> pass =
      makePass(device_, {&color, 1}, subpass,
               dependency(kDrawn | kCopied, kWritten, kDrawn,
                          VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | kWritten),
               dependency(kDrawn, kWritten, kCopied, VK_ACCESS_TRANSFER_READ_BIT));
  if (!pass) return pass.error();
  picturePass_ = *pass;
  return {};
}

Result<void> VulkanTargets::make(const CanvasTarget& target) {
  destroyImages();
  target_ = target;
  // The view that kernels sample is an array; so are the images that the scene is drawn to.
  const ImageDef color = {kSceneFormat,
                          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                          VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 1};
  const ImageDef samples = {kSceneFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                            VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, target.samples};
  const ImageDef depth = {
      kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
      VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, target.samples};
  const ImageDef picture = {pictureFormat_,
                            VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                            VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D, 1};
  const bool resolves = target.samples > 1;
  ScenePasses& passes = scenePasses_[target.samples];
  Result<void> made = makeScenePasses(device_, target.samples, passes);
  if (made) made = makeImage(device_, target, color, scene_);
  if (made && resolves) made = makeImage(device_, target, samples, samples_);
  if (made) made = makeImage(device_, target, depth, depth_);
  if (made) made = makeImage(device_, target, picture, picture_);
  if (!made) return made;
  const VkImageView views[] = {resolves ? samples_.view : scene_.view, depth_.view, scene_.view};
  Result<VkFramebuffer> scene =
      makeFramebuffer(device_, target, passes.clear, std::span(views).first(resolves ? 3 : 2));
  if (!scene) return scene.error();
  sceneFrame_ = *scene;
  Result<VkFramebuffer> shown = makeFramebuffer(device_, target, picturePass_, {&picture_.view, 1});
  if (!shown) return shown.error();
  pictureFrame_ = *shown;
  return {};
}

void VulkanTargets::destroyImages() {
  for (VkFramebuffer* frame : {&sceneFrame_, &pictureFrame_}) {
    vkDestroyFramebuffer(device_.device, *frame, nullptr);
    *frame = VK_NULL_HANDLE;
  }
  for (VulkanImage* image : {&scene_, &samples_, &depth_, &picture_}) {
    vkDestroyImageView(device_.device, image->view, nullptr);
    vkDestroyImage(device_.device, image->image, nullptr);
    vkFreeMemory(device_.device, image->memory, nullptr);
    *image = {};
  }
}

void VulkanTargets::beginScene(VkCommandBuffer commands, bool clears) const {
  std::array<VkClearValue, 2> values = {};
  values[1].depthStencil.depth = target_.reversedDepth ? 0.0f : 1.0f;
  auto begin = tagged<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
  const ScenePasses& passes = scenePasses_.at(target_.samples);
  begin.renderPass = clears ? passes.clear : passes.load;
  begin.framebuffer = sceneFrame_;
  begin.renderArea = area();
  begin.clearValueCount = static_cast<uint32_t>(values.size());
  begin.pClearValues = values.data();
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
}

void VulkanTargets::beginPicture(VkCommandBuffer commands) const {
  auto begin = tagged<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
  begin.renderPass = picturePass_;
  begin.framebuffer = pictureFrame_;
  begin.renderArea = area();
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
}

void VulkanTargets::copyDepth(VkCommandBuffer commands, const VkRect2D& area,
                              const pelage::vulkan::BufferRange& to) const {
  // Barriers of the lists do not cover this copy: it waits for every earlier use of the buffer, and
  // every later use waits for it.
  auto memory = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  VkImageMemoryBarrier image = barrierOf(depth_.image, VK_IMAGE_ASPECT_DEPTH_BIT,
                                         VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                                         VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  image.srcAccessMask = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  image.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       0, 1, &memory, 0, nullptr, 1, &image);
  VkBufferImageCopy copy = {};
  copy.bufferOffset = to.offset;
  copy.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1};
  copy.imageOffset = {area.offset.x, area.offset.y, 0};
  copy.imageExtent = {area.extent.width, area.extent.height, 1};
  vkCmdCopyImageToBuffer(commands, depth_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.buffer, 1,
                         &copy);
  memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  image.srcAccessMask = 0;
  image.dstAccessMask =
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  std::swap(image.oldLayout, image.newLayout);
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       0, 1, &memory, 0, nullptr, 1, &image);
}

pelage::vulkan::TargetFormats VulkanTargets::sceneFormats() const {
  pelage::vulkan::TargetFormats formats;
  formats.color = kSceneFormat;
  formats.depth = kDepthFormat;
  formats.samples = static_cast<VkSampleCountFlagBits>(target_.samples);
  formats.renderPass =
      scenePasses_.at(target_.samples).clear;  // its pipelines also fit the compatible pass
  return formats;
}

pelage::vulkan::TargetFormats VulkanTargets::pictureFormats() const {
  pelage::vulkan::TargetFormats formats;
  formats.color = pictureFormat_;
  formats.depth = VK_FORMAT_UNDEFINED;
  formats.renderPass = picturePass_;
  return formats;
}

VulkanSwapchain::~VulkanSwapchain() {
  destroySemaphores();
  if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_.device, swapchain_, nullptr);
}

void VulkanSwapchain::destroySemaphores() {
  for (const VkSemaphore semaphore : copied_)
    vkDestroySemaphore(device_.device, semaphore, nullptr);
  copied_.clear();
}

Result<void> VulkanSwapchain::chooseFormat() {
  uint32_t count = 0;
  VkResult result =
      vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, device_.surface, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  if (result == VK_SUCCESS)
    result = vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, device_.surface, &count,
                                                  formats.data());
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceFormatsKHR");
  // The kernel of the picture encodes colors. An encoding format would change ImGui's.
  const auto found = std::find_if(formats.begin(), formats.end(), [](const auto& format) {
    return (format.format == VK_FORMAT_B8G8R8A8_UNORM ||
            format.format == VK_FORMAT_R8G8B8A8_UNORM) &&
           format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
  });
  if (found == formats.end())
    return Error{ErrorCode::kUnsupported,
                 "the window has no format of 8 bits a channel: use --api gl"};
  format_ = *found;
  VkSurfaceCapabilitiesKHR surface = {};
  result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical, device_.surface, &surface);
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  if ((surface.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT) == 0)
    return Error{ErrorCode::kUnsupported,
                 "the images of the window cannot be copied to: use --api gl"};
  return {};
}

Result<void> VulkanSwapchain::make(uint32_t width, uint32_t height, bool vsync) {
  VkSurfaceCapabilitiesKHR surface = {};
  VkResult result =
      vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical, device_.surface, &surface);
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  auto info = tagged<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
  info.surface = device_.surface;
  info.minImageCount = std::max(2u, surface.minImageCount);
  if (surface.maxImageCount > 0)
    info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
  info.imageFormat = format_.format;
  info.imageColorSpace = format_.colorSpace;
  info.imageExtent = surface.currentExtent;
  if (info.imageExtent.width == UINT32_MAX)
    info.imageExtent = {
        std::clamp(width, surface.minImageExtent.width, surface.maxImageExtent.width),
        std::clamp(height, surface.minImageExtent.height, surface.maxImageExtent.height)};
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = surface.currentTransform;
  info.compositeAlpha = (surface.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) != 0
                            ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                            : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;  // every device has it
  if (!vsync) {
    VkPresentModeKHR modes[8];
    uint32_t count = static_cast<uint32_t>(std::size(modes));
    const VkResult listed =
        vkGetPhysicalDeviceSurfacePresentModesKHR(device_.physical, device_.surface, &count, modes);
    if ((listed == VK_SUCCESS || listed == VK_INCOMPLETE) &&
        std::find(modes, modes + count, VK_PRESENT_MODE_IMMEDIATE_KHR) != modes + count)
      info.presentMode = VK_PRESENT_MODE_IMMEDIATE_KHR;
  }
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  VkSwapchainKHR made = VK_NULL_HANDLE;
  if (info.imageExtent.width == 0 || info.imageExtent.height == 0) {
    extent_ = {};
    isStale_ = false;
    return {};
  }
  result = vkCreateSwapchainKHR(device_.device, &info, nullptr, &made);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateSwapchainKHR");
  if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_.device, swapchain_, nullptr);
  swapchain_ = made;
  extent_ = info.imageExtent;
  Result<void> taken = takeImages();
  if (taken) isStale_ = false;
  return taken;
}

// Takes the images of a new swapchain, and makes their semaphores.
Result<void> VulkanSwapchain::takeImages() {
  uint32_t count = 0;
  VkResult result = vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, nullptr);
  images_.resize(count);
  if (result == VK_SUCCESS)
    result = vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, images_.data());
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetSwapchainImagesKHR");
  destroySemaphores();
  copied_.resize(count);
  for (VkSemaphore& semaphore : copied_) {
    const auto create = tagged<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    result = vkCreateSemaphore(device_.device, &create, nullptr, &semaphore);
    if (result != VK_SUCCESS) return vulkanError(result, "vkCreateSemaphore");
  }
  return {};
}

std::optional<uint32_t> VulkanSwapchain::acquire(VkSemaphore acquired) {
  if (extent_.width == 0) return std::nullopt;
  uint32_t image = 0;
  const VkResult result =
      vkAcquireNextImageKHR(device_.device, swapchain_, std::numeric_limits<uint64_t>::max(),
                            acquired, VK_NULL_HANDLE, &image);
  isStale_ |= result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
  if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) return std::nullopt;
  return image;
}

void VulkanSwapchain::copy(VkCommandBuffer commands, VkImage picture, VkExtent2D size,
                           uint32_t image) const {
  VkImageMemoryBarrier barrier =
      barrierOf(images_[image], VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                       0, nullptr, 0, nullptr, 1, &barrier);
  VkImageCopy copy = {};
  copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.extent = {std::min(size.width, extent_.width), std::min(size.height, extent_.height), 1};
  vkCmdCopyImage(commands, picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, barrier.image,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = 0;
  barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.newLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 0, nullptr, 0, nullptr, 1,
                       &barrier);
}

Result<void> VulkanSwapchain::present(uint32_t image) {
  auto info = tagged<VkPresentInfoKHR>(VK_STRUCTURE_TYPE_PRESENT_INFO_KHR);
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = &copied_[image];
  info.swapchainCount = 1;
  info.pSwapchains = &swapchain_;
  info.pImageIndices = &image;
  const VkResult result = vkQueuePresentKHR(device_.queue, &info);
  isStale_ |= result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
  if (result == VK_ERROR_DEVICE_LOST || result == VK_ERROR_SURFACE_LOST_KHR)
    return vulkanError(result, "vkQueuePresentKHR");
  return {};
}

}  // namespace viewer
