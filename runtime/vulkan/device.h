// Facts about the caller's device, for every part of the runtime.
#pragma once

#include <vector>

#include "functions.h"
#include "pelage/tier.h"

namespace pelage::vulkan {

struct Device {
  Functions vk;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice handle = VK_NULL_HANDLE;
  uint32_t queueFamily = 0;  ///< of the command buffers that are recorded
  const VkAllocationCallbacks* callbacks = nullptr;
  VkPhysicalDeviceProperties properties = {};
  VkPhysicalDeviceMemoryProperties memory = {};
  VkQueueFamilyProperties queue = {};  ///< of queueFamily
  /// RuntimeDef::queueFamily and otherQueueFamilies, each once.
  std::vector<uint32_t> families;
  std::vector<VkQueueFamilyProperties> familyProperties;  ///< [family]
  uint32_t timestampBits = 0;                             ///< that timestamps of all of these have
  VkPhysicalDeviceFeatures features = {};                 ///< those enabled
  VkPhysicalDeviceSubgroupProperties subgroup = {};
  VkDeviceSize maxAllocation = 0;  ///< bytes of one allocation
  TierLimits tierLimits;           ///< of permutations; no more than those of RuntimeDef::maxTier

  const VkPhysicalDeviceLimits& limits() const { return properties.limits; }
  bool draws() const { return (queue.queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0; }
};

}  // namespace pelage::vulkan
