// What a frame is drawn into: the scene's linear color with depth, and the picture that the window
// shows.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <map>

#include "canvas/canvas.h"
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
/// next one. With several samples a pixel, each render pass of the scene resolves its color at its
/// end.
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
  pelage::Result<void> make(const CanvasTarget& target);
  /// Begins the render pass of the scene. \param clears the first one of a frame.
  void beginScene(VkCommandBuffer commands, bool clears) const;
  void beginPicture(VkCommandBuffer commands) const;
  /// Copies the scene's depth of an area into a buffer, between two of its render passes.
  void copyDepth(VkCommandBuffer commands, const VkRect2D& area,
                 const pelage::vulkan::BufferRange& to) const;
  pelage::vulkan::TargetFormats sceneFormats() const;
  pelage::vulkan::TargetFormats pictureFormats() const;
  VkRect2D area() const { return {{0, 0}, {target_.width, target_.height}}; }
  VkRenderPass picturePass() const { return picturePass_; }
  VkImage picture() const { return picture_.image; }
  VkImageView sceneView() const { return scene_.view; }

 private:
  /// Of the scene: for the first list of a frame, and for those behind it.
  struct ScenePasses {
    VkRenderPass clear = VK_NULL_HANDLE, load = VK_NULL_HANDLE;
  };
  pelage::Result<VkRenderPass> scenePass(uint32_t samples, bool clears) const;
  pelage::Result<void> makeScenePasses(uint32_t samples);
  const ScenePasses& scenePasses() const { return scenePasses_.at(target_.samples); }
  pelage::Result<void> makeImage(VulkanImage& image, VkFormat format, VkImageUsageFlags usage,
                                 VkImageAspectFlags aspect, VkImageViewType type,
                                 uint32_t samples) const;
  pelage::Result<VkFramebuffer> makeFramebuffer(VkRenderPass pass, const VkImageView* views,
                                                uint32_t count) const;
  void destroyImages();

  const VulkanDevice& device_;
  CanvasTarget target_;
  VkFormat pictureFormat_ = VK_FORMAT_UNDEFINED;
  std::map<uint32_t, ScenePasses> scenePasses_;  // [samples], as far as they were wanted
  VkRenderPass picturePass_ = VK_NULL_HANDLE;
  VulkanImage scene_, samples_, depth_, picture_;  // samples_: only with several of them
  VkFramebuffer sceneFrame_ = VK_NULL_HANDLE, pictureFrame_ = VK_NULL_HANDLE;
};

}  // namespace viewer
