// The images of Vulkan: the targets of a frame, and the images of the window.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "canvas/canvas.h"
#include "canvas/vulkan/device.h"
#include "pelage/vulkan.h"

namespace viewer {

struct VulkanImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

/// A buffer that the host reads.
class VulkanReadback {
 public:
  explicit VulkanReadback(const VulkanDevice& device) : device_(device) {}
  ~VulkanReadback() { release(); }
  VulkanReadback(const VulkanReadback&) = delete;
  VulkanReadback& operator=(const VulkanReadback&) = delete;
  /// Makes the buffer; there is none yet.
  pelage::Result<void> make(VkDeviceSize size);
  void release();
  VkBuffer buffer() const { return buffer_; }
  const void* mapped() const { return mapped_; }

 private:
  const VulkanDevice& device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  void* mapped_ = nullptr;
};

/// The render passes of the scene with a number of samples: for the first list of a frame, and for
/// later ones.
struct ScenePasses {
  VkRenderPass clear = VK_NULL_HANDLE, load = VK_NULL_HANDLE;
};

/// The targets of a frame: the scene's linear color with depth, and the picture that the window
/// shows. The render passes live as long as the object, images and framebuffers until the next
/// make(). With several samples a pixel, each render pass of the scene resolves its color at its
/// end.
class VulkanTargets {
 public:
  static constexpr VkFormat kSceneFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

  explicit VulkanTargets(const VulkanDevice& device) : device_(device) {}
  ~VulkanTargets();
  VulkanTargets(const VulkanTargets&) = delete;
  VulkanTargets& operator=(const VulkanTargets&) = delete;

  /// \param picture format of the picture: the swapchain's.
  pelage::Result<void> makePasses(VkFormat picture);
  pelage::Result<void> make(const CanvasTarget& target);
  /// Begins the render pass of the scene. \param clears for the first list of a frame.
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
  void destroyImages();
  const VulkanDevice& device_;
  CanvasTarget target_;
  VkFormat pictureFormat_ = VK_FORMAT_UNDEFINED;
  std::map<uint32_t, ScenePasses> scenePasses_;  // [samples] that were used
  VkRenderPass picturePass_ = VK_NULL_HANDLE;
  VulkanImage scene_, samples_, depth_, picture_;  // samples_: with several a pixel
  VkFramebuffer sceneFrame_ = VK_NULL_HANDLE, pictureFrame_ = VK_NULL_HANDLE;
};

/// The images of a window.
class VulkanSwapchain {
 public:
  explicit VulkanSwapchain(const VulkanDevice& device) : device_(device) {}
  ~VulkanSwapchain();
  VulkanSwapchain(const VulkanSwapchain&) = delete;
  VulkanSwapchain& operator=(const VulkanSwapchain&) = delete;

  /// Chooses the format of all swapchains of the surface. Errors: no format of 8 bits a channel
  /// without encoding; images that cannot be copied to.
  pelage::Result<void> chooseFormat();
  /// Makes the images again. The device must be idle.
  pelage::Result<void> make(uint32_t width, uint32_t height, bool vsync);

  VkFormat format() const { return format_.format; }
  /// Whether the images do not fit the window any more: make() is due.
  bool isStale() const { return isStale_; }
  /// Acquires an image of the window; nothing if there is none. A frame without an image still
  /// runs. \param acquired is signaled when the image is there.
  std::optional<uint32_t> acquire(VkSemaphore acquired);
  /// Copies a picture into an image. \param size of the picture [pixels].
  void copy(VkCommandBuffer commands, VkImage picture, VkExtent2D size, uint32_t image) const;
  /// A semaphore that is signaled when the copy into an image has finished.
  VkSemaphore copied(uint32_t image) const { return copied_[image]; }
  /// Shows an image after its copy. Errors: the device or the surface is lost.
  pelage::Result<void> present(uint32_t image);

 private:
  pelage::Result<void> takeImages();
  void destroySemaphores();
  const VulkanDevice& device_;
  VkSurfaceFormatKHR format_ = {};
  VkExtent2D extent_ = {};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  std::vector<VkImage> images_;
  std::vector<VkSemaphore> copied_;
  bool isStale_ = false;
};

}  // namespace viewer
