// Pictures that the engine of the Vulkan tests draws into, by render passes and without.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "pelage/vulkan.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {

/// The attachments of a target.
struct TargetKind {
  const char* name;
  bool dynamic = true;
  VkFormat depth = VK_FORMAT_D32_SFLOAT;  ///< of the image
  bool attachesDepth = true, attachesStencil = false;
  std::vector<VkFormat> others = {};  ///< VK_FORMAT_UNDEFINED: a hole
};

/// The images of a target on an engine's device.
class VulkanTarget {
 public:
  static constexpr uint32_t kSize = 48;  ///< width and height
  static constexpr VkFormat kColor = VK_FORMAT_R8G8B8A8_UNORM;
  static constexpr VkFormat kBoth = VK_FORMAT_D32_SFLOAT_S8_UINT;
  static constexpr uint32_t kClearedStencil = 7;

  VulkanTarget(const runtime_test::Engine& engine, const TargetKind& kind)
      : engine_(engine), kind_(kind) {
    color_ = make(kColor);
    if (kind.attachesDepth || kind.attachesStencil) depth_ = make(kind.depth);
    for (const VkFormat format : kind.others)
      others_.push_back(format != VK_FORMAT_UNDEFINED ? make(format) : Image{});
    if (kind.dynamic) return;
    for (const bool load : {false, true}) passes_[load ? 1 : 0] = makePass(load);
    std::vector<VkImageView> views;
    for (const Image* image : attachments()) views.push_back(image->view);
    auto info =
        runtime_test::tagged<VkFramebufferCreateInfo>(VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO);
    info.renderPass = passes_[0];
    info.attachmentCount = static_cast<uint32_t>(views.size());
    info.pAttachments = views.data();
    info.width = info.height = kSize;
    info.layers = 1;
    EXPECT_EQ(vkCreateFramebuffer(engine.device(), &info, nullptr, &framebuffer_), VK_SUCCESS);
  }
  ~VulkanTarget() {
    vkDestroyFramebuffer(engine_.device(), framebuffer_, nullptr);
    for (const VkRenderPass pass : passes_) vkDestroyRenderPass(engine_.device(), pass, nullptr);
    for (const Image* image : attachments()) engine_.destroyImage(*image);
  }
  VulkanTarget(const VulkanTarget&) = delete;
  VulkanTarget& operator=(const VulkanTarget&) = delete;

  vulkan::TargetFormats formats() const {
    vulkan::TargetFormats formats;
    formats.color = kColor;
    formats.depth = kind_.attachesDepth ? kind_.depth : VK_FORMAT_UNDEFINED;
    formats.renderPass = passes_[0];
    if (kind_.dynamic && kind_.attachesStencil) formats.stencil = kind_.depth;
    formats.otherColorCount = static_cast<uint32_t>(kind_.others.size());
    if (kind_.dynamic)
      std::copy(kind_.others.begin(), kind_.others.end(), formats.otherColors.begin());
    return formats;
  }
  VkRenderPass renderPass() const { return passes_[0]; }

  /// Before the first render pass.
  void prepare(VkCommandBuffer commands) const {
    for (const Image* image : attachments()) {
      transition(commands, *image, VK_IMAGE_LAYOUT_UNDEFINED, attachmentLayout(*image));
    }
  }
  void begin(VkCommandBuffer commands, bool clears) const {
    auto barrier = runtime_test::tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
    if (kind_.dynamic)
      beginRendering(commands, clears);
    else
      beginPass(commands, clears);
  }
  void end(VkCommandBuffer commands) const {
    if (kind_.dynamic)
      vkCmdEndRendering(commands);
    else
      vkCmdEndRenderPass(commands);
  }
  /// [0] the first color, then the others without holes, and the stencil last where there is one.
  std::vector<runtime_test::EngineBuffer> copyOut(VkCommandBuffer commands) const {
    std::vector<runtime_test::EngineBuffer> outs;
    const auto copy = [&](const Image& image, VkImageAspectFlags aspect) {
      outs.push_back(engine_.createBuffer(VkDeviceSize{kSize} * kSize * 16,
                                          VK_BUFFER_USAGE_TRANSFER_DST_BIT, true));
      std::memset(outs.back().mapped, 0, size_t{kSize} * kSize * 16);
      transition(commands, image, attachmentLayout(image), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
      VkBufferImageCopy region = {};
      region.imageSubresource = {aspect, 0, 0, 1};
      region.imageExtent = {kSize, kSize, 1};
      vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                             outs.back().buffer, 1, &region);
    };
    copy(color_, VK_IMAGE_ASPECT_COLOR_BIT);
    for (const Image& other : others_)
      if (other.image != VK_NULL_HANDLE) copy(other, VK_IMAGE_ASPECT_COLOR_BIT);
    if (kind_.attachesStencil) copy(depth_, VK_IMAGE_ASPECT_STENCIL_BIT);
    return outs;
  }

 private:
  using Image = runtime_test::EngineImage;

  static VkImageAspectFlags aspectsOf(VkFormat format) {
    if (format == VK_FORMAT_S8_UINT) return VK_IMAGE_ASPECT_STENCIL_BIT;
    if (format == kBoth) return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    if (format == VK_FORMAT_D32_SFLOAT) return VK_IMAGE_ASPECT_DEPTH_BIT;
    return VK_IMAGE_ASPECT_COLOR_BIT;
  }

  static VkClearValue clearOf(VkFormat format) {
    VkClearValue clear = {};
    if (aspectsOf(format) != VK_IMAGE_ASPECT_COLOR_BIT) {
      clear.depthStencil = {1, kClearedStencil};
    } else if (format == VK_FORMAT_R32_UINT) {
      clear.color.uint32[0] = 0x01020304;
    } else {
      for (float& value : clear.color.float32) value = 0.2f;
    }
    return clear;
  }

  // In the order of a render pass.
  std::vector<const Image*> attachments() const {
    std::vector<const Image*> all = {&color_};
    for (const Image& other : others_)
      if (other.image != VK_NULL_HANDLE) all.push_back(&other);
    if (depth_.image != VK_NULL_HANDLE) all.push_back(&depth_);
    return all;
  }
  static VkImageLayout attachmentLayout(const Image& image) {
    return image.aspects == VK_IMAGE_ASPECT_COLOR_BIT
               ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
               : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  }
  static void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from,
                         VkImageLayout to) {
    auto barrier =
        runtime_test::tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.image;
    barrier.subresourceRange = {image.aspects, 0, 1, 0, 1};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &barrier);
  }

  Image make(VkFormat format) const {
    return engine_.createImage(format, aspectsOf(format), kSize);
  }

  VkRenderPass makePass(bool load) const {
    std::vector<VkAttachmentDescription> descriptions;
    std::vector<VkAttachmentReference> colors;
    VkAttachmentReference depth = {VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_UNDEFINED};
    for (const Image* image : attachments()) {
      const VkImageLayout layout = attachmentLayout(*image);
      const VkAttachmentReference reference = {static_cast<uint32_t>(descriptions.size()), layout};
      if (image == &depth_)
        depth = reference;
      else
        colors.push_back(reference);
      VkAttachmentDescription description = {};
      description.format = image->format;
      description.samples = VK_SAMPLE_COUNT_1_BIT;
      description.loadOp = load ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
      description.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
      description.stencilLoadOp = description.loadOp;
      description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE;
      description.initialLayout = description.finalLayout = layout;
      descriptions.push_back(description);
    }
    VkSubpassDescription subpass = {};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    subpass.pColorAttachments = colors.data();
    subpass.pDepthStencilAttachment = &depth;
    auto info =
        runtime_test::tagged<VkRenderPassCreateInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO);
    info.attachmentCount = static_cast<uint32_t>(descriptions.size());
    info.pAttachments = descriptions.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    VkRenderPass pass = VK_NULL_HANDLE;
    EXPECT_EQ(vkCreateRenderPass(engine_.device(), &info, nullptr, &pass), VK_SUCCESS);
    return pass;
  }

  void beginPass(VkCommandBuffer commands, bool clears) const {
    std::vector<VkClearValue> values;
    for (const Image* image : attachments())
      values.push_back(image == &color_ ? VkClearValue{} : clearOf(image->format));
    auto info =
        runtime_test::tagged<VkRenderPassBeginInfo>(VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO);
    info.renderPass = passes_[clears ? 0 : 1];
    info.framebuffer = framebuffer_;
    info.renderArea.extent = {kSize, kSize};
    info.clearValueCount = static_cast<uint32_t>(values.size());
    info.pClearValues = values.data();
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
  }

  void beginRendering(VkCommandBuffer commands, bool clears) const {
    const auto attach = [&](const Image& image) {
      auto info = runtime_test::tagged<VkRenderingAttachmentInfo>(
          VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
      info.imageView = image.view;
      if (image.view == VK_NULL_HANDLE) return info;
      info.imageLayout = attachmentLayout(image);
      info.loadOp = clears ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
      info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
      if (&image != &color_) info.clearValue = clearOf(image.format);
      return info;
    };
    std::vector<VkRenderingAttachmentInfo> colors = {attach(color_)};
    for (const Image& other : others_) colors.push_back(attach(other));
    const VkRenderingAttachmentInfo depth = attach(depth_);
    auto info = runtime_test::tagged<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
    info.renderArea.extent = {kSize, kSize};
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    info.pColorAttachments = colors.data();
    if (kind_.attachesDepth) info.pDepthAttachment = &depth;
    if (kind_.attachesStencil) info.pStencilAttachment = &depth;
    vkCmdBeginRendering(commands, &info);
  }

  const runtime_test::Engine& engine_;
  const TargetKind& kind_;
  Image color_, depth_;
  std::vector<Image> others_;
  VkRenderPass passes_[2] = {VK_NULL_HANDLE, VK_NULL_HANDLE};
  VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
};

}  // namespace pelage::test
