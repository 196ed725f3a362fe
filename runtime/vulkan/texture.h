// A texture of the Vulkan headless device.
#pragma once

#include "device.h"
#include "pelage/headless.h"
#include "pelage/vulkan.h"

namespace pelage::vulkan {

/// An image that shaders sample, written once. Destroyed by destroy(), before the device goes.
class Texture {
 public:
  /// On an error nothing is left.
  Result<void> make(const Device& device, const TextureDef& def);
  /// Copies its texels from the front of a buffer, and makes it ready for shaders.
  void fill(const Device& device, VkCommandBuffer commands, VkBuffer texels) const;
  void destroy(const Device& device);
  ExternalTexture external() const { return {.view = view_, .sampler = sampler_}; }

 private:
  Result<void> makeImage(const Device& device, const TextureDef& def);
  Result<void> makeViewAndSampler(const Device& device, const TextureDef& def);

  uint32_t width_ = 0, height_ = 0, layers_ = 0, levels_ = 0;
  VkDeviceSize texelBytes_ = 0;
  VkImage image_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkSampler sampler_ = VK_NULL_HANDLE;
};

}  // namespace pelage::vulkan
