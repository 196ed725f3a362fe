#include "canvas/vulkan/targets.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <utility>

namespace viewer {

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

}  // namespace

Result<VulkanReadback> makeReadback(const VulkanDevice& device, VkDeviceSize size) {
  VulkanReadback buffer;
  buffer.size = size;
  const auto fail = [&](VkResult result) {
    destroyReadback(device, buffer);
    return vulkanError(result, fmt::format("a buffer of {} bytes to read back", size));
  };
  auto info = tagged<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkResult result = vkCreateBuffer(device.device, &info, nullptr, &buffer.buffer);
  if (result != VK_SUCCESS) return fail(result);
  VkMemoryRequirements needs = {};
  vkGetBufferMemoryRequirements(device.device, buffer.buffer, &needs);
  auto memory = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  memory.allocationSize = needs.size;
  memory.memoryTypeIndex =
      device.memoryType(needs.memoryTypeBits,
                        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  result = vkAllocateMemory(device.device, &memory, nullptr, &buffer.memory);
  if (result == VK_SUCCESS)
    result = vkBindBufferMemory(device.device, buffer.buffer, buffer.memory, 0);
  void* mapped = nullptr;
  if (result == VK_SUCCESS)
    result = vkMapMemory(device.device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &mapped);
  if (result != VK_SUCCESS) return fail(result);
  buffer.mapped = mapped;
  return buffer;
}

void destroyReadback(const VulkanDevice& device, VulkanReadback& buffer) {
  vkDestroyBuffer(device.device, buffer.buffer, nullptr);
  vkFreeMemory(device.device, buffer.memory, nullptr);
  buffer = {};
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

// Between its render passes the color can be sampled, and the depth stays where it is; so do the
// samples, of which the color is the mean.
Result<VkRenderPass> VulkanTargets::scenePass(uint32_t samples, bool clears) const {
  const VkAttachmentLoadOp load = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  const auto before = [&](VkImageLayout layout) {
    return clears ? VK_IMAGE_LAYOUT_UNDEFINED : layout;
  };
  constexpr VkImageLayout kRead = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  constexpr VkImageLayout kDepth = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  constexpr VkImageLayout kColor = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  const VkImageLayout drawn = samples > 1 ? kColor : kRead;
  const VkAttachmentDescription attachments[] = {
      attachment(kSceneFormat, samples, load, before(drawn), drawn),
      attachment(kDepthFormat, samples, load, before(kDepth), kDepth),
      attachment(kSceneFormat, 1, VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
                 kRead)};
  const VkAttachmentReference color = {0, kColor};
  const VkAttachmentReference depth = {1, kDepth};
  const VkAttachmentReference resolved = {2, kColor};
  VkSubpassDescription subpass = {};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &color;
  subpass.pResolveAttachments = samples > 1 ? &resolved : nullptr;
  subpass.pDepthStencilAttachment = &depth;
  VkSubpassDependency dependencies[2] = {};
  dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[0].srcStageMask = kAttachmentStages | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
  dependencies[0].dstStageMask = kAttachmentStages;
  dependencies[0].srcAccessMask = kAttachmentAccess;
  dependencies[0].dstAccessMask = kAttachmentAccess;
  dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[1].srcStageMask = kAttachmentStages;
  dependencies[1].dstStageMask = kAttachmentStages | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
  dependencies[1].srcAccessMask = kAttachmentAccess;
  dependencies[1].dstAccessMask = kAttachmentAccess | VK_ACCESS_SHADER_READ_BIT;
  auto info = tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
  info.attachmentCount = samples > 1 ? 3 : 2;
  info.pAttachments = attachments;
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<uint32_t>(std::size(dependencies));
  info.pDependencies = dependencies;
  VkRenderPass pass = VK_NULL_HANDLE;
  const VkResult made = vkCreateRenderPass(device_.device, &info, nullptr, &pass);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateRenderPass");
  return pass;
}

Result<void> VulkanTargets::makeScenePasses(uint32_t samples) {
  ScenePasses& passes = scenePasses_[samples];
  for (VkRenderPass* pass : {&passes.clear, &passes.load}) {
    if (*pass != VK_NULL_HANDLE) continue;
    Result<VkRenderPass> made = scenePass(samples, pass == &passes.clear);
    if (!made) return made.error();
    *pass = *made;
  }
  return {};
}

Result<void> VulkanTargets::makePasses(VkFormat picture) {
  pictureFormat_ = picture;
  // All of it is drawn over, and then copied.
  const VkAttachmentDescription color =
      attachment(picture, 1, VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
                 VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const VkAttachmentReference reference = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass = {};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  VkSubpassDependency dependencies[2] = {};
  dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[0].srcStageMask =
      VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  dependencies[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  dependencies[0].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  dependencies[0].dstAccessMask =
      VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
  dependencies[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  dependencies[1].dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
  dependencies[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  dependencies[1].dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  auto info = tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
  info.attachmentCount = 1;
  info.pAttachments = &color;
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<uint32_t>(std::size(dependencies));
  info.pDependencies = dependencies;
  const VkResult made = vkCreateRenderPass(device_.device, &info, nullptr, &picturePass_);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateRenderPass");
  return {};
}

Result<void> VulkanTargets::makeImage(VulkanImage& image, VkFormat format, VkImageUsageFlags usage,
                                      VkImageAspectFlags aspect, VkImageViewType type,
                                      uint32_t samples) const {
  const auto fail = [&](VkResult result) {
    return vulkanError(result, fmt::format("a target of {} x {} pixels with {} samples each",
                                           target_.width, target_.height, samples));
  };
  auto info = tagged<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {target_.width, target_.height, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = static_cast<VkSampleCountFlagBits>(samples);
  info.usage = usage;
  VkResult result = vkCreateImage(device_.device, &info, nullptr, &image.image);
  if (result != VK_SUCCESS) return fail(result);
  VkMemoryRequirements needs = {};
  vkGetImageMemoryRequirements(device_.device, image.image, &needs);
  auto memory = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  memory.allocationSize = needs.size;
  memory.memoryTypeIndex =
      device_.memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  result = vkAllocateMemory(device_.device, &memory, nullptr, &image.memory);
  if (result == VK_SUCCESS)
    result = vkBindImageMemory(device_.device, image.image, image.memory, 0);
  if (result != VK_SUCCESS) return fail(result);
  auto view = tagged<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = image.image;
  view.viewType = type;
  view.format = format;
  view.subresourceRange = {aspect, 0, 1, 0, 1};
  result = vkCreateImageView(device_.device, &view, nullptr, &image.view);
  if (result != VK_SUCCESS) return fail(result);
  return {};
}

Result<VkFramebuffer> VulkanTargets::makeFramebuffer(VkRenderPass pass, const VkImageView* views,
                                                     uint32_t count) const {
  auto info = tagged<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
  info.renderPass = pass;
  info.attachmentCount = count;
  info.pAttachments = views;
  info.width = target_.width;
  info.height = target_.height;
  info.layers = 1;
  VkFramebuffer frame = VK_NULL_HANDLE;
  const VkResult made = vkCreateFramebuffer(device_.device, &info, nullptr, &frame);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateFramebuffer");
  return frame;
}

Result<void> VulkanTargets::make(const CanvasTarget& target) {
  destroyImages();
  target_ = target;
  Result<void> made = makeScenePasses(target.samples);
  // The view that kernels sample is an array; so is what is drawn to.
  if (made)
    made = makeImage(scene_, kSceneFormat,
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, 1);
  if (made && target.samples > 1)
    made = makeImage(samples_, kSceneFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, target.samples);
  if (made)
    made = makeImage(depth_, kDepthFormat,
                     VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_VIEW_TYPE_2D_ARRAY, target.samples);
  if (made)
    made = makeImage(picture_, pictureFormat_,
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_VIEW_TYPE_2D, 1);
  if (!made) return made;
  const bool resolves = target.samples > 1;
  const VkImageView views[] = {resolves ? samples_.view : scene_.view, depth_.view, scene_.view};
  Result<VkFramebuffer> scene = makeFramebuffer(scenePasses().clear, views, resolves ? 3 : 2);
  if (!scene) return scene.error();
  sceneFrame_ = *scene;
  Result<VkFramebuffer> picture = makeFramebuffer(picturePass_, &picture_.view, 1);
  if (!picture) return picture.error();
  pictureFrame_ = *picture;
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
  begin.renderPass = clears ? scenePasses().clear : scenePasses().load;
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
  // The lists' hazards do not know of this copy: it waits for every use of the buffer before it,
  // and every use after it waits here.
  auto memory = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  auto image = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
  image.srcAccessMask = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  image.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  image.oldLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  image.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  image.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image.image = depth_.image;
  image.subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1};
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
  formats.renderPass = scenePasses().clear;  // its pipelines serve the compatible one as well
  return formats;
}

pelage::vulkan::TargetFormats VulkanTargets::pictureFormats() const {
  pelage::vulkan::TargetFormats formats;
  formats.color = pictureFormat_;
  formats.depth = VK_FORMAT_UNDEFINED;
  formats.renderPass = picturePass_;
  return formats;
}

}  // namespace viewer
