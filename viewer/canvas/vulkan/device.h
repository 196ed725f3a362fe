// A Vulkan device that can draw into a window.
#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "canvas/canvas.h"
#include "pelage/headless.h"
#include "pelage/result.h"

namespace viewer {

/// Returns a zeroed structure of Vulkan with its type.
template <class T>
constexpr T tagged(VkStructureType type) {
  T structure = {};
  structure.sType = type;
  return structure;
}

/// Returns the error of a call that failed; kDeviceLost and kOutOfMemory if Vulkan reports them.
pelage::Error vulkanError(VkResult result, std::string_view what);

/// Instance, surface, device and queue.
class VulkanDevice {
 public:
  VulkanDevice() = default;
  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;
  /// Errors: no loader, no device that presents to the window, no validation layer.
  pelage::Result<void> open(const CanvasDef& def, Window& window);

  /// Allocates memory of a type with all of these properties, or of any type that fits.
  VkResult allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags wanted,
                    VkDeviceMemory& memory) const;

  VkInstance instance = VK_NULL_HANDLE;
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties = {};
  VkPhysicalDeviceFeatures features = {};  ///< the enabled ones
  uint32_t queueFamily = 0;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  bool debugUtils = false;
  std::atomic<uint32_t> messages{0};
  pelage::DeviceInfo info;  ///< without its tier

 private:
  pelage::Result<void> createInstance(bool validation);
  pelage::Result<void> choosePhysical(int index);
  pelage::Result<void> createDevice();
  void describe();
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties memory_ = {};
};

}  // namespace viewer
