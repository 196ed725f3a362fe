#include "canvas/vulkan/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <optional>
#include <vector>

#include "window/glfw.h"
#include "window/window.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr uint32_t kSampleCounts = 1 | 2 | 4 | 8;  // values of View::samples

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void* user) {
  static_cast<std::atomic<uint32_t>*>(user)->fetch_add(1);
  std::fprintf(stderr, "pelage-viewer: Vulkan: %s\n", data->pMessage);
  return VK_FALSE;
}

std::string versionText(uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

bool hasValidation() {
  uint32_t count = 0;
  if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkLayerProperties> layers(count);
  if (vkEnumerateInstanceLayerProperties(&count, layers.data()) != VK_SUCCESS) return false;
  return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
    return std::strcmp(layer.layerName, kValidationLayer) == 0;
  });
}

int rankOf(VkPhysicalDeviceType type) {
  if (type == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU) return 0;
  if (type == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU) return 1;
  if (type == VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU) return 2;
  return type == VK_PHYSICAL_DEVICE_TYPE_CPU ? 3 : 4;
}

bool hasSwapchains(VkPhysicalDevice physical) {
  uint32_t count = 0;
  if (vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr) != VK_SUCCESS)
    return false;
  std::vector<VkExtensionProperties> all(count);
  if (vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, all.data()) != VK_SUCCESS)
    return false;
  return std::any_of(all.begin(), all.end(), [](const VkExtensionProperties& extension) {
    return std::strcmp(extension.extensionName, VK_KHR_SWAPCHAIN_EXTENSION_NAME) == 0;
  });
}

// Returns a family that computes, draws and presents to the surface.
std::optional<uint32_t> familyOf(VkPhysicalDevice physical, VkSurfaceKHR surface) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (uint32_t i = 0; i < count; ++i) {
    VkBool32 presents = VK_FALSE;
    if ((families[i].queueFlags & kWanted) != kWanted) continue;
    if (vkGetPhysicalDeviceSurfaceSupportKHR(physical, i, surface, &presents) != VK_SUCCESS)
      continue;
    if (presents == VK_TRUE) return i;
  }
  return std::nullopt;
}

}  // namespace

Error vulkanError(VkResult result, std::string_view what) {
  ErrorCode code = ErrorCode::kDevice;
  if (result == VK_ERROR_DEVICE_LOST) code = ErrorCode::kDeviceLost;
  if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY)
    code = ErrorCode::kOutOfMemory;
  return {code, fmt::format("{} failed ({}{})", what, static_cast<int>(result),
                            code == ErrorCode::kDeviceLost    ? ", the device is lost"
                            : code == ErrorCode::kOutOfMemory ? ", out of memory"
                                                              : "")};
}

VulkanDevice::~VulkanDevice() {
  if (device != VK_NULL_HANDLE) vkDestroyDevice(device, nullptr);
  if (instance == VK_NULL_HANDLE) return;
  vkDestroySurfaceKHR(instance, surface, nullptr);
  if (messenger_ != VK_NULL_HANDLE) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance, messenger_, nullptr);
  }
  vkDestroyInstance(instance, nullptr);
}

Result<void> VulkanDevice::open(const CanvasDef& def, Window& window) {
  if (Result<void> done = createInstance(def.validation); !done) return done;
  const VkResult made = glfwCreateWindowSurface(instance, window.handle(), nullptr, &surface);
  if (made != VK_SUCCESS) return vulkanError(made, "making a surface of the window");
  if (Result<void> done = choosePhysical(def.deviceIndex); !done) return done;
  if (Result<void> done = createDevice(); !done) return done;
  describe();
  return {};
}

Result<void> VulkanDevice::createInstance(bool validation) {
  uint32_t count = 0;
  const char** needed = glfwGetRequiredInstanceExtensions(&count);
  if (glfwVulkanSupported() != GLFW_TRUE || needed == nullptr) {
    return Error{ErrorCode::kUnsupported,
                 "there is no Vulkan driver that shows windows. On Debian: apt-get install "
                 "mesa-vulkan-drivers, or the driver of the GPU; or use --api gl"};
  }
  std::vector<const char*> extensions(needed, needed + count);
  auto application = tagged<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "pelage-viewer";
  application.apiVersion = VK_API_VERSION_1_1;
  auto create = tagged<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  create.pApplicationInfo = &application;
  auto messenger = tagged<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  messenger.pUserData = &messages;
  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  auto validated = tagged<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  validated.enabledValidationFeatureCount = 1;
  validated.pEnabledValidationFeatures = enabled;
  if (validation) {
    if (!hasValidation())
      return Error{ErrorCode::kUnsupported,
                   "validation was asked for and its layer is not there. On Debian: apt-get "
                   "install vulkan-validationlayers"};
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &kValidationLayer;
    messenger.pNext = &validated;
    create.pNext = &messenger;
    debugUtils = true;
  }
  create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  if (const VkResult made = vkCreateInstance(&create, nullptr, &instance); made != VK_SUCCESS)
    return vulkanError(made, "vkCreateInstance");
  if (!validation) return {};
  messenger.pNext = nullptr;
  const auto createMessenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
  const VkResult made = createMessenger(instance, &messenger, nullptr, &messenger_);
  if (made != VK_SUCCESS) return vulkanError(made, "vkCreateDebugUtilsMessengerEXT");
  return {};
}

Result<void> VulkanDevice::choosePhysical(int index) {
  uint32_t count = 0;
  VkResult result = vkEnumeratePhysicalDevices(instance, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  if (result == VK_SUCCESS && count > 0)
    result = vkEnumeratePhysicalDevices(instance, &count, devices.data());
  if (result != VK_SUCCESS) return vulkanError(result, "vkEnumeratePhysicalDevices");
  std::string names;
  int best = -1;
  for (size_t i = 0; i < devices.size(); ++i) {
    VkPhysicalDeviceProperties here = {};
    vkGetPhysicalDeviceProperties(devices[i], &here);
    names += fmt::format("{}{}: {}", i == 0 ? "" : ", ", i, here.deviceName);
    const auto family = familyOf(devices[i], surface);
    const bool wanted = index < 0
                            ? best < 0 || rankOf(here.deviceType) < rankOf(properties.deviceType)
                            : static_cast<int>(i) == index;
    if (!wanted || !family || here.apiVersion < VK_API_VERSION_1_1 || !hasSwapchains(devices[i]))
      continue;
    best = static_cast<int>(i);
    physical = devices[i];
    queueFamily = *family;
    properties = here;
  }
  if (best < 0)
    return Error{ErrorCode::kUnsupported,
                 fmt::format("no Vulkan 1.1 device draws into this window; the devices are: {}. "
                             "Use --api gl",
                             names.empty() ? "none" : names)};
  vkGetPhysicalDeviceMemoryProperties(physical, &memory_);
  return {};
}

Result<void> VulkanDevice::createDevice() {
  VkPhysicalDeviceFeatures supported = {};
  vkGetPhysicalDeviceFeatures(physical, &supported);
  features.fragmentStoresAndAtomics = supported.fragmentStoresAndAtomics;
  features.vertexPipelineStoresAndAtomics = supported.vertexPipelineStoresAndAtomics;
  features.fullDrawIndexUint32 = supported.fullDrawIndexUint32;
  const float priority = 1;
  auto queues = tagged<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queues.queueFamilyIndex = queueFamily;
  queues.queueCount = 1;
  queues.pQueuePriorities = &priority;
  const char* extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
  auto create = tagged<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queues;
  create.pEnabledFeatures = &features;
  create.enabledExtensionCount = 1;
  create.ppEnabledExtensionNames = &extension;
  const VkResult made = vkCreateDevice(physical, &create, nullptr, &device);
  if (made != VK_SUCCESS)
    return vulkanError(made, fmt::format("vkCreateDevice on {}", properties.deviceName));
  vkGetDeviceQueue(device, queueFamily, 0, &queue);
  return {};
}

void VulkanDevice::describe() {
  info.api = pelage::Api::kVulkan;
  info.name = properties.deviceName;
  info.driver = fmt::format("driver version {:#x}", properties.driverVersion);
  info.version = versionText(properties.apiVersion);
  info.software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info.maxBufferBytes = properties.limits.maxStorageBufferRange;
  const VkPhysicalDeviceLimits& limits = properties.limits;
  info.sampleCounts =
      limits.framebufferColorSampleCounts & limits.framebufferDepthSampleCounts & kSampleCounts;
  info.maxSamples = std::bit_floor(info.sampleCounts);
}

VkResult VulkanDevice::allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags wanted,
                                VkDeviceMemory& memory) const {
  const auto fits = [&](uint32_t type) { return (needs.memoryTypeBits >> type & 1u) != 0; };
  const auto has = [&](uint32_t type) {
    return (memory_.memoryTypes[type].propertyFlags & wanted) == wanted;
  };
  auto request = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  request.allocationSize = needs.size;
  for (uint32_t type = memory_.memoryTypeCount; type-- > 0;)
    if (fits(type)) request.memoryTypeIndex = type;
  for (uint32_t type = memory_.memoryTypeCount; type-- > 0;)
    if (fits(type) && has(type)) request.memoryTypeIndex = type;
  return vkAllocateMemory(device, &request, nullptr, &memory);
}

}  // namespace viewer
