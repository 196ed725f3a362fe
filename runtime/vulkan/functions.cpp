#include "functions.h"

#include <fmt/format.h>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace pelage::vulkan {
namespace {

Result<void> openLoader(PFN_vkGetInstanceProcAddr& out) {
  // The loader stays open for the life of the process: drivers and layers do not like to be
  // unloaded, and a second runtime needs it again.
#if defined(_WIN32)
  static const HMODULE library = LoadLibraryA("vulkan-1.dll");
  const char* const name = "vulkan-1.dll";
  auto symbol = library ? reinterpret_cast<PFN_vkGetInstanceProcAddr>(
                              GetProcAddress(library, "vkGetInstanceProcAddr"))
                        : nullptr;
#else
#if defined(__APPLE__)
  const char* const name = "libvulkan.1.dylib";
#else
  const char* const name = "libvulkan.so.1";
#endif
  static void* const library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  auto symbol =
      library ? reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"))
              : nullptr;
#endif
  if (symbol == nullptr) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("no Vulkan loader: {} was not found. On Debian: apt-get install "
                             "libvulkan1 mesa-vulkan-drivers",
                             name)};
  }
  out = symbol;
  return {};
}

template <class Function>
bool assign(Function& function, PFN_vkVoidFunction found) {
  function = reinterpret_cast<Function>(found);
  return function != nullptr;
}

Error missingFunction(std::string_view name) {
  return {ErrorCode::kUnsupported,
          fmt::format("Vulkan has no function vk{}: the runtime needs Vulkan 1.1", name)};
}

}  // namespace

Result<void> Functions::loadGlobal(PFN_vkGetInstanceProcAddr loader) {
  if (loader == nullptr) {
    if (Result<void> opened = openLoader(loader); !opened) return opened;
  }
  GetInstanceProcAddr = loader;
  EnumerateInstanceVersion = reinterpret_cast<PFN_vkEnumerateInstanceVersion>(
      GetInstanceProcAddr(VK_NULL_HANDLE, "vkEnumerateInstanceVersion"));
#define PELAGE_VULKAN_LOAD(function)                                            \
  if (!assign((function), GetInstanceProcAddr(VK_NULL_HANDLE, "vk" #function))) \
    return missingFunction(#function);
  PELAGE_VULKAN_GLOBAL_FUNCTIONS(PELAGE_VULKAN_LOAD)
#undef PELAGE_VULKAN_LOAD
  return {};
}

Result<void> Functions::loadInstance(VkInstance instance) {
#define PELAGE_VULKAN_LOAD(function)                                      \
  if (!assign((function), GetInstanceProcAddr(instance, "vk" #function))) \
    return missingFunction(#function);
  PELAGE_VULKAN_INSTANCE_FUNCTIONS(PELAGE_VULKAN_LOAD)
#undef PELAGE_VULKAN_LOAD
  return {};
}

Result<void> Functions::loadDevice(VkInstance instance, VkDevice device, bool debugUtils) {
#define PELAGE_VULKAN_LOAD(function)                                  \
  if (!assign((function), GetDeviceProcAddr(device, "vk" #function))) \
    return missingFunction(#function);
  PELAGE_VULKAN_DEVICE_FUNCTIONS(PELAGE_VULKAN_LOAD)
#undef PELAGE_VULKAN_LOAD
  dynamicRendering = GetDeviceProcAddr(device, "vkCmdBeginRendering") != nullptr ||
                     GetDeviceProcAddr(device, "vkCmdBeginRenderingKHR") != nullptr;
  if (debugUtils) {
    // An instance extension: its device functions come through the instance too.
    SetDebugUtilsObjectName = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        GetInstanceProcAddr(instance, "vkSetDebugUtilsObjectNameEXT"));
    CmdBeginDebugUtilsLabel = reinterpret_cast<PFN_vkCmdBeginDebugUtilsLabelEXT>(
        GetInstanceProcAddr(instance, "vkCmdBeginDebugUtilsLabelEXT"));
    CmdEndDebugUtilsLabel = reinterpret_cast<PFN_vkCmdEndDebugUtilsLabelEXT>(
        GetInstanceProcAddr(instance, "vkCmdEndDebugUtilsLabelEXT"));
  }
  return {};
}

void Functions::nameObject(VkDevice device, VkObjectType type, uint64_t handle,
                           const char* text) const {
  if (SetDebugUtilsObjectName == nullptr || handle == 0) return;
  auto info =
      tagged<VkDebugUtilsObjectNameInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
  info.objectType = type;
  info.objectHandle = handle;
  info.pObjectName = text;
  // A name that cannot be set is no reason to fail.
  static_cast<void>(SetDebugUtilsObjectName(device, &info));
}

std::string resultName(VkResult result) {
  switch (result) {
    case VK_SUCCESS:
      return "VK_SUCCESS";
    case VK_NOT_READY:
      return "VK_NOT_READY";
    case VK_TIMEOUT:
      return "VK_TIMEOUT";
    case VK_INCOMPLETE:
      return "VK_INCOMPLETE";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "VK_ERROR_OUT_OF_HOST_MEMORY";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "VK_ERROR_INITIALIZATION_FAILED";
    case VK_ERROR_DEVICE_LOST:
      return "VK_ERROR_DEVICE_LOST";
    case VK_ERROR_MEMORY_MAP_FAILED:
      return "VK_ERROR_MEMORY_MAP_FAILED";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "VK_ERROR_LAYER_NOT_PRESENT";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "VK_ERROR_EXTENSION_NOT_PRESENT";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "VK_ERROR_FEATURE_NOT_PRESENT";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "VK_ERROR_INCOMPATIBLE_DRIVER";
    case VK_ERROR_TOO_MANY_OBJECTS:
      return "VK_ERROR_TOO_MANY_OBJECTS";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      return "VK_ERROR_FORMAT_NOT_SUPPORTED";
    case VK_ERROR_FRAGMENTED_POOL:
      return "VK_ERROR_FRAGMENTED_POOL";
    case VK_ERROR_OUT_OF_POOL_MEMORY:
      return "VK_ERROR_OUT_OF_POOL_MEMORY";
    case VK_ERROR_UNKNOWN:
      return "VK_ERROR_UNKNOWN";
    default:
      return fmt::format("VkResult {}", static_cast<int>(result));
  }
}

Error vulkanError(VkResult result, std::string_view what) {
  ErrorCode code = ErrorCode::kDevice;
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_FRAGMENTED_POOL:
    case VK_ERROR_TOO_MANY_OBJECTS:
      code = ErrorCode::kOutOfMemory;
      break;
    case VK_ERROR_LAYER_NOT_PRESENT:
    case VK_ERROR_EXTENSION_NOT_PRESENT:
    case VK_ERROR_FEATURE_NOT_PRESENT:
    case VK_ERROR_INCOMPATIBLE_DRIVER:
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      code = ErrorCode::kUnsupported;
      break;
    case VK_ERROR_DEVICE_LOST:
      return {ErrorCode::kDeviceLost,
              fmt::format("{}: VK_ERROR_DEVICE_LOST; destroy the runtime, make another device and "
                          "runtime, and call Scene::recover()",
                          what)};
    default:
      break;
  }
  return {code, fmt::format("{}: {}", what, resultName(result))};
}

}  // namespace pelage::vulkan
