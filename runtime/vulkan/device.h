// Facts about the caller's device, for every part of the runtime.
#pragma once

#include "functions.h"
#include "pelage/tier.h"

namespace pelage::vulkan {

struct Device {
  Functions vk;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice handle = VK_NULL_HANDLE;
  uint32_t queueFamily = 0;
  const VkAllocationCallbacks* callbacks = nullptr;
  VkPhysicalDeviceProperties properties = {};
  VkPhysicalDeviceMemoryProperties memory = {};
  VkQueueFamilyProperties queue = {};
  VkPhysicalDeviceFeatures features = {};  ///< those enabled
  VkPhysicalDeviceSubgroupProperties subgroup = {};
  VkDeviceSize maxAllocation = 0;  ///< bytes of one allocation
  TierLimits tierLimits;           ///< of permutations; no more than those of RuntimeDef::maxTier

  const VkPhysicalDeviceLimits& limits() const { return properties.limits; }
};

}  // namespace pelage::vulkan
