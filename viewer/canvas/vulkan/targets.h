// What a frame is drawn into: the scene's linear color with depth, and the picture that the window
// shows.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>

#include "canvas/vulkan/device.h"
#include "pelage/vulkan.h"

namespace viewer {

struct VulkanImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

/// A buffer that the host sees.
struct VulkanReadback {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  const void* mapped = nullptr;
  VkDeviceSize size = 0;
};
pelage::Result<VulkanReadback> makeReadback(const VulkanDevice& device, VkDeviceSize size);
void destroyReadback(const VulkanDevice& device, VulkanReadback& buffer);

/// The render passes live as long as this does, the images and framebuffers from make() to the
/// next one.
class VulkanTargets {
 public:
  static constexpr VkFormat kSceneFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

  explicit VulkanTargets(const VulkanDevice& device) : device_(device) {}
  ~VulkanTargets();
  VulkanTargets(const VulkanTargets&) = delete;
  VulkanTargets& operator=(const VulkanTargets&) = delete;

  /// \param picture format of the picture: that of the swapchain.
  pelage::Result<void> makePasses(VkFormat picture);
  pelage::Result<void> make(uint32_t width, uint32_t height);
  /// Begins the render pass of the scene. \param clears the first one of a frame.
  void beginScene(VkCommandBuffer commands, bool clears) const;
  void beginPicture(VkCommandBuffer commands) const;
  /// Copies the scene's depth of an area into a buffer, between two of its render passes.
  void copyDepth(VkCommandBuffer commands, const VkRect2D& area,
                 const pelage::vulkan::BufferRange& to) const;
  pelage::vulkan::TargetFormats sceneFormats() const;
  pelage::vulkan::TargetFormats pictureFormats() const;
  VkRect2D area() const { return {{0, 0}, {width_, height_}}; }
  VkRenderPass picturePass() const { return picturePass_; }
  VkImage picture() const { return picture_.image; }
  VkImageView sceneView() const { return scene_.view; }

 private:
  pelage::Result<VkRenderPass> scenePass(bool clears) const;
  pelage::Result<void> makeImage(VulkanImage& image, VkFormat format, VkImageUsageFlags usage,
                                 VkImageAspectFlags aspect, VkImageViewType type) const;
  pelage::Result<VkFramebuffer> makeFramebuffer(VkRenderPass pass, const VkImageView* views,
                                                uint32_t count) const;
  void destroyImages();

  const VulkanDevice& device_;
  uint32_t width_ = 0, height_ = 0;
  VkFormat pictureFormat_ = VK_FORMAT_UNDEFINED;
  VkRenderPass clearPass_ = VK_NULL_HANDLE, loadPass_ = VK_NULL_HANDLE,
               picturePass_ = VK_NULL_HANDLE;
  VulkanImage scene_, depth_, picture_;
  VkFramebuffer sceneFrame_ = VK_NULL_HANDLE, pictureFrame_ = VK_NULL_HANDLE;
};

}  // namespace viewer
