// The images of a window.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <vector>

#include "canvas/vulkan/device.h"

namespace viewer {

class VulkanSwapchain {
 public:
  explicit VulkanSwapchain(const VulkanDevice& device) : device_(device) {}
  ~VulkanSwapchain();
  VulkanSwapchain(const VulkanSwapchain&) = delete;
  VulkanSwapchain& operator=(const VulkanSwapchain&) = delete;

  /// Chooses the format of all swapchains of the surface. Errors: none of 8 bits a channel that is
  /// not encoded, or images that cannot be copied to.
  pelage::Result<void> chooseFormat();
  /// Makes the images anew; the device is idle.
  pelage::Result<void> make(uint32_t width, uint32_t height, bool vsync);

  VkFormat format() const { return format_.format; }
  VkExtent2D extent() const { return extent_; }
  VkSwapchainKHR handle() const { return swapchain_; }
  VkImage image(uint32_t index) const { return images_[index]; }
  /// Is signalled when the copy into an image has finished.
  VkSemaphore copied(uint32_t index) const { return copied_[index]; }

 private:
  void destroySemaphores();
  const VulkanDevice& device_;
  VkSurfaceFormatKHR format_ = {};
  VkExtent2D extent_ = {};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  std::vector<VkImage> images_;
  std::vector<VkSemaphore> copied_;
};

}  // namespace viewer
