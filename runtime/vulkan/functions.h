// The Vulkan functions that the runtime calls, loaded through the caller's vkGetInstanceProcAddr.
#pragma once

#include <vulkan/vulkan_core.h>

#include <new>
#include <string>
#include <string_view>

#include "pelage/result.h"

namespace pelage::vulkan {

#define PELAGE_VULKAN_GLOBAL_FUNCTIONS(X) \
  X(CreateInstance)                       \
  X(EnumerateInstanceExtensionProperties) \
  X(EnumerateInstanceLayerProperties)

#define PELAGE_VULKAN_INSTANCE_FUNCTIONS(X) \
  X(CreateDevice)                           \
  X(DestroyInstance)                        \
  X(EnumerateDeviceExtensionProperties)     \
  X(EnumeratePhysicalDevices)               \
  X(GetDeviceProcAddr)                      \
  X(GetPhysicalDeviceFeatures)              \
  X(GetPhysicalDeviceFormatProperties)      \
  X(GetPhysicalDeviceMemoryProperties)      \
  X(GetPhysicalDeviceProperties)            \
  X(GetPhysicalDeviceProperties2)           \
  X(GetPhysicalDeviceQueueFamilyProperties) \
  X(GetPhysicalDeviceImageFormatProperties)

#define PELAGE_VULKAN_DEVICE_FUNCTIONS(X) \
  X(AllocateCommandBuffers)               \
  X(AllocateDescriptorSets)               \
  X(AllocateMemory)                       \
  X(BeginCommandBuffer)                   \
  X(BindBufferMemory)                     \
  X(BindImageMemory)                      \
  X(CmdBeginRenderPass)                   \
  X(CmdBindDescriptorSets)                \
  X(CmdBindIndexBuffer)                   \
  X(CmdBindVertexBuffers)                 \
  X(CmdBindPipeline)                      \
  X(CmdCopyBuffer)                        \
  X(CmdCopyBufferToImage)                 \
  X(CmdCopyImageToBuffer)                 \
  X(CmdDispatch)                          \
  X(CmdDispatchIndirect)                  \
  X(CmdDraw)                              \
  X(CmdDrawIndexed)                       \
  X(CmdDrawIndirect)                      \
  X(CmdEndRenderPass)                     \
  X(CmdFillBuffer)                        \
  X(CmdPipelineBarrier)                   \
  X(CmdResetQueryPool)                    \
  X(CmdSetScissor)                        \
  X(CmdSetViewport)                       \
  X(CmdWriteTimestamp)                    \
  X(CreateBuffer)                         \
  X(CreateCommandPool)                    \
  X(CreateComputePipelines)               \
  X(CreateDescriptorPool)                 \
  X(CreateDescriptorSetLayout)            \
  X(CreateFence)                          \
  X(CreateFramebuffer)                    \
  X(CreateGraphicsPipelines)              \
  X(CreateImage)                          \
  X(CreateImageView)                      \
  X(CreatePipelineCache)                  \
  X(CreatePipelineLayout)                 \
  X(CreateQueryPool)                      \
  X(CreateRenderPass)                     \
  X(CreateSampler)                        \
  X(CreateShaderModule)                   \
  X(DestroyBuffer)                        \
  X(DestroyCommandPool)                   \
  X(DestroyDescriptorPool)                \
  X(DestroyDescriptorSetLayout)           \
  X(DestroyDevice)                        \
  X(DestroyFence)                         \
  X(DestroyFramebuffer)                   \
  X(DestroyImage)                         \
  X(DestroyImageView)                     \
  X(DestroyPipeline)                      \
  X(DestroyPipelineCache)                 \
  X(DestroyPipelineLayout)                \
  X(DestroyQueryPool)                     \
  X(DestroyRenderPass)                    \
  X(DestroySampler)                       \
  X(DestroyShaderModule)                  \
  X(DeviceWaitIdle)                       \
  X(EndCommandBuffer)                     \
  X(FreeMemory)                           \
  X(GetBufferMemoryRequirements)          \
  X(GetDeviceQueue)                       \
  X(GetImageMemoryRequirements)           \
  X(GetPipelineCacheData)                 \
  X(GetQueryPoolResults)                  \
  X(MapMemory)                            \
  X(QueueSubmit)                          \
  X(ResetCommandPool)                     \
  X(ResetFences)                          \
  X(UpdateDescriptorSets)                 \
  X(WaitForFences)

/// Function pointers, named as in Vulkan without the "vk".
struct Functions {
  PFN_vkGetInstanceProcAddr GetInstanceProcAddr = nullptr;
  /// Absent from Vulkan 1.0 loaders.
  PFN_vkEnumerateInstanceVersion EnumerateInstanceVersion = nullptr;
#define PELAGE_VULKAN_DECLARE(name) PFN_vk##name name = nullptr;
  PELAGE_VULKAN_GLOBAL_FUNCTIONS(PELAGE_VULKAN_DECLARE)
  PELAGE_VULKAN_INSTANCE_FUNCTIONS(PELAGE_VULKAN_DECLARE)
  PELAGE_VULKAN_DEVICE_FUNCTIONS(PELAGE_VULKAN_DECLARE)
#undef PELAGE_VULKAN_DECLARE
  // VK_EXT_debug_utils; null unless asked for.
  PFN_vkSetDebugUtilsObjectNameEXT SetDebugUtilsObjectName = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT CmdBeginDebugUtilsLabel = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT CmdEndDebugUtilsLabel = nullptr;
  /// Whether vkCmdBeginRendering can be had, from Vulkan 1.3 or the extension.
  bool dynamicRendering = false;

  /// The functions that exist without an instance. `loader` nullptr opens the system's loader.
  Result<void> loadGlobal(PFN_vkGetInstanceProcAddr loader);
  /// Adds the functions of an instance.
  Result<void> loadInstance(VkInstance instance);
  /// Adds the functions of a device.
  Result<void> loadDevice(VkInstance instance, VkDevice device, bool debugUtils);

  /// Names an object for debuggers, where that is enabled.
  template <class Handle>
  void name(VkDevice device, VkObjectType type, Handle handle, const char* text) const {
    // Non-dispatchable handles are integers on 32-bit platforms; the C cast serves both kinds.
    nameObject(device, type, (uint64_t)handle, text);
  }

 private:
  void nameObject(VkDevice device, VkObjectType type, uint64_t handle, const char* text) const;
};

/// A zeroed structure of Vulkan with its type set.
template <class T>
constexpr T tagged(VkStructureType type) {
  T structure = {};
  structure.sType = type;
  return structure;
}

/// A plane with one level, one layer and one sample a pixel.
inline VkImageCreateInfo imageInfo(VkFormat format, uint32_t width, uint32_t height,
                                   VkImageUsageFlags usage) {
  auto info = tagged<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {width, height, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = usage;
  return info;
}

/// "VK_ERROR_DEVICE_LOST" and the like.
std::string resultName(VkResult result);

/// The error of a failed call: `what` says what was being done.
Error vulkanError(VkResult result, std::string_view what);

/// Runs f and turns exceptions of the standard library into errors: none may cross the API.
template <class F>
auto guarded(F&& f) -> decltype(f()) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kOutOfMemory, "out of host memory in the Vulkan runtime"};
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("the Vulkan runtime failed: ") + exception.what()};
  }
}

}  // namespace pelage::vulkan
