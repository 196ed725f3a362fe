#include "canvas/vulkan/swapchain.h"

#include <algorithm>
#include <iterator>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

VulkanSwapchain::~VulkanSwapchain() {
  destroySemaphores();
  if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_.device, swapchain_, nullptr);
}

void VulkanSwapchain::destroySemaphores() {
  for (const VkSemaphore semaphore : copied_)
    vkDestroySemaphore(device_.device, semaphore, nullptr);
  copied_.clear();
}

Result<void> VulkanSwapchain::chooseFormat() {
  uint32_t count = 0;
  VkResult result =
      vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, device_.surface, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  if (result == VK_SUCCESS)
    result = vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical, device_.surface, &count,
                                                  formats.data());
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceFormatsKHR");
  // The kernel of the picture encodes, so that ImGui's colors are what they are meant to be.
  const auto found = std::find_if(formats.begin(), formats.end(), [](const auto& format) {
    return (format.format == VK_FORMAT_B8G8R8A8_UNORM ||
            format.format == VK_FORMAT_R8G8B8A8_UNORM) &&
           format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
  });
  if (found == formats.end())
    return Error{ErrorCode::kUnsupported,
                 "the window has no format of 8 bits a channel: use --api gl"};
  format_ = *found;
  VkSurfaceCapabilitiesKHR surface = {};
  result = vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical, device_.surface, &surface);
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  if ((surface.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT) == 0)
    return Error{ErrorCode::kUnsupported,
                 "the images of the window cannot be copied to: use --api gl"};
  return {};
}

Result<void> VulkanSwapchain::make(uint32_t width, uint32_t height, bool vsync) {
  VkSurfaceCapabilitiesKHR surface = {};
  VkResult result =
      vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical, device_.surface, &surface);
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  auto info = tagged<VkSwapchainCreateInfoKHR>(VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR);
  info.surface = device_.surface;
  info.minImageCount = std::max(2u, surface.minImageCount);
  if (surface.maxImageCount > 0)
    info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
  info.imageFormat = format_.format;
  info.imageColorSpace = format_.colorSpace;
  info.imageExtent = surface.currentExtent;
  if (info.imageExtent.width == UINT32_MAX)
    info.imageExtent = {
        std::clamp(width, surface.minImageExtent.width, surface.maxImageExtent.width),
        std::clamp(height, surface.minImageExtent.height, surface.maxImageExtent.height)};
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = surface.currentTransform;
  info.compositeAlpha = (surface.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) != 0
                            ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                            : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;  // the one that every device has
  if (!vsync) {
    VkPresentModeKHR modes[8];
    uint32_t count = static_cast<uint32_t>(std::size(modes));
    const VkResult listed =
        vkGetPhysicalDeviceSurfacePresentModesKHR(device_.physical, device_.surface, &count, modes);
    if ((listed == VK_SUCCESS || listed == VK_INCOMPLETE) &&
        std::find(modes, modes + count, VK_PRESENT_MODE_IMMEDIATE_KHR) != modes + count)
      info.presentMode = VK_PRESENT_MODE_IMMEDIATE_KHR;
  }
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  VkSwapchainKHR made = VK_NULL_HANDLE;
  if (info.imageExtent.width == 0 || info.imageExtent.height == 0) {
    extent_ = {};
    return {};
  }
  result = vkCreateSwapchainKHR(device_.device, &info, nullptr, &made);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateSwapchainKHR");
  if (swapchain_ != VK_NULL_HANDLE) vkDestroySwapchainKHR(device_.device, swapchain_, nullptr);
  swapchain_ = made;
  extent_ = info.imageExtent;
  uint32_t count = 0;
  result = vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, nullptr);
  images_.resize(count);
  if (result == VK_SUCCESS)
    result = vkGetSwapchainImagesKHR(device_.device, swapchain_, &count, images_.data());
  if (result != VK_SUCCESS) return vulkanError(result, "vkGetSwapchainImagesKHR");
  destroySemaphores();
  copied_.resize(count);
  for (VkSemaphore& semaphore : copied_) {
    const auto create = tagged<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    result = vkCreateSemaphore(device_.device, &create, nullptr, &semaphore);
    if (result != VK_SUCCESS) return vulkanError(result, "vkCreateSemaphore");
  }
  return {};
}

}  // namespace viewer
