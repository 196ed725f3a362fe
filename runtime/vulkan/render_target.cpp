#include "render_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

namespace pelage::vulkan {

namespace {

// The color, the depth and, with several samples, the image that they are resolved into.
std::vector<VkAttachmentDescription> attachmentsOf(VkFormat format, VkSampleCountFlagBits samples,
                                                   bool load) {
  const bool resolves = samples != VK_SAMPLE_COUNT_1_BIT;
  std::vector<VkAttachmentDescription> attachments(resolves ? 3 : 2);
  VkAttachmentDescription& color = attachments[0];
  color.format = format;
  color.samples = samples;
  color.loadOp = load ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
  color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  color.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  color.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  color.finalLayout =
      resolves ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  color.initialLayout = load ? color.finalLayout : VK_IMAGE_LAYOUT_UNDEFINED;
  VkAttachmentDescription& depth = attachments[1];
  depth = color;
  depth.format = RenderTarget::kDepthFormat;
  depth.finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  depth.initialLayout = load ? depth.finalLayout : VK_IMAGE_LAYOUT_UNDEFINED;
  if (resolves) {
    VkAttachmentDescription& resolve = attachments[2];
    resolve = color;
    resolve.samples = VK_SAMPLE_COUNT_1_BIT;
    resolve.loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    resolve.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    resolve.finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  }
  return attachments;
}

// The pass waits for draws and copies before it; copies after it wait for its color.
std::array<VkSubpassDependency, 2> dependenciesOfPass() {
  constexpr VkPipelineStageFlags kAttachmentStages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                                     VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                                     VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  VkSubpassDependency before = {};
  before.srcSubpass = VK_SUBPASS_EXTERNAL;
  before.dstSubpass = 0;
  before.srcStageMask = kAttachmentStages | VK_PIPELINE_STAGE_TRANSFER_BIT;
  before.dstStageMask = kAttachmentStages;
  before.srcAccessMask =
      VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  before.dstAccessMask =
      VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  VkSubpassDependency after = {};
  after.srcSubpass = 0;
  after.dstSubpass = VK_SUBPASS_EXTERNAL;
  after.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  after.dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
  after.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  after.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  return {before, after};
}

struct ImageDef {
  VkFormat format;
  VkImageUsageFlags usage;
  VkSampleCountFlagBits samples;
  VkImageAspectFlags aspect;
  const char* name;
};

Result<void> makeImage(const Device& device, const RenderTargetDef& target, const ImageDef& def,
                       TargetImage& image) {
  const Functions& vk = device.vk;
  const auto failed = [&](VkResult result) {
    return vulkanError(result,
                       fmt::format("{} image of {} x {} pixels, {} samples", def.name, target.width,
                                   target.height, static_cast<uint32_t>(def.samples)));
  };
  VkImageCreateInfo info = imageInfo(def.format, target.width, target.height, def.usage);
  info.samples = def.samples;
  VkResult result = vk.CreateImage(device.handle, &info, nullptr, &image.image);
  if (result != VK_SUCCESS) return failed(result);
  vk.name(device.handle, VK_OBJECT_TYPE_IMAGE, image.image, def.name);

  VkMemoryRequirements needs = {};
  vk.GetImageMemoryRequirements(device.handle, image.image, &needs);
  const VkPhysicalDeviceMemoryProperties& types = device.memory;
  uint32_t type = types.memoryTypeCount;
  for (uint32_t i = 0; i < types.memoryTypeCount; ++i) {
    if ((needs.memoryTypeBits >> i & 1u) == 0) continue;
    if (type == types.memoryTypeCount) type = i;
    if ((types.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0) {
      type = i;
      break;
    }
  }
  auto memory = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  memory.allocationSize = needs.size;
  memory.memoryTypeIndex = type;
  result = vk.AllocateMemory(device.handle, &memory, nullptr, &image.memory);
  if (result != VK_SUCCESS) return failed(result);
  result = vk.BindImageMemory(device.handle, image.image, image.memory, 0);
  if (result != VK_SUCCESS) return failed(result);

  auto view = tagged<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = image.image;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = def.format;
  view.subresourceRange = {def.aspect, 0, 1, 0, 1};
  result = vk.CreateImageView(device.handle, &view, nullptr, &image.view);
  if (result != VK_SUCCESS) return failed(result);
  return {};
}

Result<VkRenderPass> makeRenderPass(const Device& device, VkFormat format,
                                    VkSampleCountFlagBits samples, bool load) {
  const bool resolves = samples != VK_SAMPLE_COUNT_1_BIT;
  const std::vector<VkAttachmentDescription> attachments = attachmentsOf(format, samples, load);
  const VkAttachmentReference colorReference = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depthReference = {1,
                                                VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference resolveReference = {2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass = {};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &colorReference;
  subpass.pDepthStencilAttachment = &depthReference;
  if (resolves) subpass.pResolveAttachments = &resolveReference;

  const std::array<VkSubpassDependency, 2> dependencies = dependenciesOfPass();

  auto info = tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
  info.attachmentCount = static_cast<uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<uint32_t>(std::size(dependencies));
  info.pDependencies = dependencies.data();
  VkRenderPass pass = VK_NULL_HANDLE;
  const VkResult result = device.vk.CreateRenderPass(device.handle, &info, nullptr, &pass);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateRenderPass");
  return pass;
}

void destroyImage(const Device& device, TargetImage& image) {
  device.vk.DestroyImageView(device.handle, image.view, nullptr);
  device.vk.DestroyImage(device.handle, image.image, nullptr);
  device.vk.FreeMemory(device.handle, image.memory, nullptr);
  image = {};
}

}  // namespace

Result<void> RenderTarget::makePasses(VkSampleCountFlagBits samples) {
  const VkFormat format = formatOf(def_);
  TargetPasses& passes = allPasses_[{format, samples}];
  for (const bool load : {false, true}) {
    VkRenderPass& pass = load ? passes.loads : passes.clears;
    if (pass != VK_NULL_HANDLE) continue;
    Result<VkRenderPass> made = makeRenderPass(device_, format, samples, load);
    if (!made) return made.error();
    pass = *made;
  }
  passes_ = passes;
  return {};
}

Result<void> RenderTarget::make(const RenderTargetDef& def) {
  destroyImages();
  def_ = def;
  const VkFormat format = formatOf(def);
  const auto samples = static_cast<VkSampleCountFlagBits>(def.samples);
  const bool resolves = def.samples > 1;
  constexpr VkImageUsageFlags kReadColor =
      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  const auto fail = [&](const Error& error) -> Result<void> {
    destroyImages();
    return error;
  };
  const ImageDef color = {
      format, resolves ? VkImageUsageFlags{VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT} : kReadColor,
      samples, VK_IMAGE_ASPECT_COLOR_BIT, "pelage/color"};
  const ImageDef depth = {
      kDepthFormat,
      resolves ? VkImageUsageFlags{VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT}
               : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
      samples, VK_IMAGE_ASPECT_DEPTH_BIT, "pelage/depth"};
  const ImageDef resolved = {format, kReadColor, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_ASPECT_COLOR_BIT,
                             "pelage/resolved color"};
  Result<void> images = makeImage(device_, def, color, color_);
  if (images) images = makeImage(device_, def, depth, depth_);
  if (images && resolves) images = makeImage(device_, def, resolved, resolve_);
  if (!images) return fail(images.error());
  std::vector<VkImageView> views = {color_.view, depth_.view};
  if (resolves) views.push_back(resolve_.view);
  if (Result<void> made = makePasses(samples); !made) return fail(made.error());
  auto info = tagged<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
  info.renderPass = passes_.clears;
  info.attachmentCount = static_cast<uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = def.width;
  info.height = def.height;
  info.layers = 1;
  const VkResult result =
      device_.vk.CreateFramebuffer(device_.handle, &info, nullptr, &framebuffer_);
  if (result != VK_SUCCESS) return fail(vulkanError(result, "vkCreateFramebuffer"));
  return {};
}

void RenderTarget::destroyImages() {
  device_.vk.DestroyFramebuffer(device_.handle, framebuffer_, nullptr);
  destroyImage(device_, color_);
  destroyImage(device_, depth_);
  destroyImage(device_, resolve_);
  framebuffer_ = VK_NULL_HANDLE;
}

void RenderTarget::destroy() {
  destroyImages();
  for (const auto& [key, passes] : allPasses_) {
    device_.vk.DestroyRenderPass(device_.handle, passes.clears, nullptr);
    device_.vk.DestroyRenderPass(device_.handle, passes.loads, nullptr);
  }
  allPasses_.clear();
}

TargetFormats RenderTarget::formats() const {
  TargetFormats formats;
  formats.color = formatOf(def_);
  formats.depth = kDepthFormat;
  formats.samples = static_cast<VkSampleCountFlagBits>(def_.samples);
  formats.renderPass = passes_.clears;  // its pipelines serve the compatible one as well
  return formats;
}

void RenderTarget::begin(VkCommandBuffer commands, const RenderTargetDef& def, bool clear) const {
  std::array<VkClearValue, 2> clears = {};
  const float color[] = {def.clearColor.x, def.clearColor.y, def.clearColor.z, def.clearColor.w};
  std::copy(std::begin(color), std::end(color), clears[0].color.float32);
  clears[1].depthStencil.depth = def.clearDepth;
  auto pass = tagged<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
  pass.renderPass = clear ? passes_.clears : passes_.loads;
  pass.framebuffer = framebuffer_;
  pass.renderArea.extent = {def_.width, def_.height};
  pass.clearValueCount = static_cast<uint32_t>(clears.size());
  pass.pClearValues = clears.data();
  device_.vk.CmdBeginRenderPass(commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
}

void RenderTarget::copyDepth(VkCommandBuffer commands, const VkRect2D& area,
                             const BufferRange& range) const {
  const Functions& vk = device_.vk;
  constexpr VkPipelineStageFlags kDepthStages =
      VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
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
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                        VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &memory, 0, nullptr, 1, &image);
  VkBufferImageCopy copy = {};
  copy.bufferOffset = range.offset;
  copy.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1};
  copy.imageOffset = {area.offset.x, area.offset.y, 0};
  copy.imageExtent = {area.extent.width, area.extent.height, 1};
  vk.CmdCopyImageToBuffer(commands, depth_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                          range.buffer, 1, &copy);
  memory.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
  image.srcAccessMask = 0;
  image.dstAccessMask =
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  std::swap(image.oldLayout, image.newLayout);
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, kDepthStages, 0, 0, nullptr, 0,
                        nullptr, 1, &image);
}

void RenderTarget::copyColor(VkCommandBuffer commands, VkBuffer buffer) const {
  const Functions& vk = device_.vk;
  VkBufferImageCopy copy = {};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = {def_.width, def_.height, 1};
  const VkImage source = def_.samples > 1 ? resolve_.image : color_.image;
  vk.CmdCopyImageToBuffer(commands, source, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &copy);
  auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                        &barrier, 0, nullptr, 0, nullptr);
}

}  // namespace pelage::vulkan
