#include "own_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace pelage::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void* user) {
  static_cast<std::atomic<uint32_t>*>(user)->fetch_add(1);
  const bool error = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  std::fprintf(stderr, "pelage: Vulkan %s: %s\n", error ? "error" : "warning", data->pMessage);
  return VK_FALSE;
}

std::string versionText(uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

template <class Properties>
bool hasExtension(const std::vector<Properties>& extensions, const char* name) {
  return std::any_of(extensions.begin(), extensions.end(), [&](const Properties& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

// 32 hexadecimal digits. The device has Vulkan 1.1.
std::string uuidOf(const Functions& vk, VkPhysicalDevice device) {
  auto ids = tagged<VkPhysicalDeviceIDProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES);
  auto properties =
      tagged<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties.pNext = &ids;
  vk.GetPhysicalDeviceProperties2(device, &properties);
  return fmt::format("{:02x}", fmt::join(ids.deviceUUID, ""));
}

// The digits alone, in lower case.
std::string plainUuid(std::string_view text) {
  if (text.starts_with("GPU-")) text.remove_prefix(4);
  std::string digits;
  for (const char c : text)
    if (c != '-') digits += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return digits;
}

// The instance extensions that validation takes. Errors: the layer or one of them is not there.
Result<std::vector<const char*>> validationExtensions(const Functions& vk) {
  uint32_t count = 0;
  VkResult result = vk.EnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  if (result == VK_SUCCESS) result = vk.EnumerateInstanceLayerProperties(&count, layers.data());
  const bool found =
      result == VK_SUCCESS && std::any_of(layers.begin(), layers.end(), [](const auto& layer) {
        return std::strcmp(layer.layerName, kValidationLayer) == 0;
      });
  if (!found) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("validation was asked for and {} is not there. On Debian: apt-get "
                             "install vulkan-validationlayers",
                             kValidationLayer)};
  }
  std::vector<VkExtensionProperties> known;
  for (const char* layer : {static_cast<const char*>(nullptr), kValidationLayer}) {
    uint32_t extensionCount = 0;
    if (vk.EnumerateInstanceExtensionProperties(layer, &extensionCount, nullptr) != VK_SUCCESS)
      continue;
    const size_t first = known.size();
    known.resize(first + extensionCount);
    static_cast<void>(
        vk.EnumerateInstanceExtensionProperties(layer, &extensionCount, known.data() + first));
    known.resize(first + extensionCount);
  }
  for (const char* name :
       {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME}) {
    if (!hasExtension(known, name)) {
      return Error{ErrorCode::kUnsupported,
                   fmt::format("validation was asked for and the instance extension {} is not "
                               "there: update the loader and {}",
                               name, kValidationLayer)};
    }
  }
  return std::vector<const char*>{VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                  VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
}

Result<void> checkLoader(const Functions& vk) {
  uint32_t version = VK_API_VERSION_1_0;
  if (vk.EnumerateInstanceVersion != nullptr)
    static_cast<void>(vk.EnumerateInstanceVersion(&version));
  if (version < VK_API_VERSION_1_1) {
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("the Vulkan loader is of version {}, 1.1 is needed. On Debian: apt-get "
                    "install libvulkan1",
                    versionText(version))};
  }
  return {};
}

VkDebugUtilsMessengerCreateInfoEXT messengerInfo(std::atomic<uint32_t>& messages) {
  auto messenger = tagged<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  // Not the general ones: the loader reports every driver that is installed without its device.
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                          VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  messenger.pUserData = &messages;
  return messenger;
}

Result<std::vector<VkPhysicalDevice>> physicalDevicesOf(const Device& device) {
  const Functions& vk = device.vk;
  uint32_t count = 0;
  VkResult result = vk.EnumeratePhysicalDevices(device.instance, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  if (result == VK_SUCCESS && count > 0)
    result = vk.EnumeratePhysicalDevices(device.instance, &count, devices.data());
  if (result != VK_SUCCESS && result != VK_ERROR_INITIALIZATION_FAILED)
    return vulkanError(result, "vkEnumeratePhysicalDevices");
  if (devices.empty()) {
    return Error{ErrorCode::kUnsupported,
                 "no Vulkan device. On Debian: apt-get install mesa-vulkan-drivers (a software "
                 "driver is among them), or the driver of the GPU"};
  }
  return devices;
}

int rankOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return 3;
    default:
      return 4;
  }
}

// The device that the definition names, or the first of the best kind.
Result<VkPhysicalDevice> pickDevice(const Functions& vk, std::span<const VkPhysicalDevice> devices,
                                    const HeadlessDef& def) {
  int index = def.deviceIndex;
  if (!def.deviceUuid.empty()) index = -1;
  std::string names;
  int best = -1;
  int bestRank = 0;
  for (size_t i = 0; i < devices.size(); ++i) {
    VkPhysicalDeviceProperties properties = {};
    vk.GetPhysicalDeviceProperties(devices[i], &properties);
    const std::string uuid =
        properties.apiVersion >= VK_API_VERSION_1_1 ? uuidOf(vk, devices[i]) : std::string();
    names += fmt::format("{}{}: {} ({})", i == 0 ? "" : ", ", i, properties.deviceName, uuid);
    if (!def.deviceUuid.empty() && uuid == plainUuid(def.deviceUuid)) index = static_cast<int>(i);
    const int here = rankOf(properties.deviceType);
    if (properties.apiVersion >= VK_API_VERSION_1_1 && (best < 0 || here < bestRank)) {
      best = static_cast<int>(i);
      bestRank = here;
    }
  }
  const bool found =
      def.deviceUuid.empty() ? index >= -1 && index < static_cast<int>(devices.size()) : index >= 0;
  if (!found) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("there is no Vulkan device {}; the devices are: {}",
                    def.deviceUuid.empty() ? std::to_string(index) : def.deviceUuid, names)};
  }
  if (index >= 0) best = index;
  if (best < 0) {
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("no device has Vulkan 1.1: update the driver; the devices are: {}", names)};
  }
  return devices[static_cast<size_t>(best)];
}

}  // namespace

void BusyClock::begin() {
  const std::lock_guard lock(mutex_);
  if (running_++ == 0) since_ = Clock::now();
}

void BusyClock::end() {
  const std::lock_guard lock(mutex_);
  if (--running_ == 0) total_ += Clock::now() - since_;
}

double BusyClock::seconds() const {
  const std::lock_guard lock(mutex_);
  const Clock::duration now = running_ > 0 ? Clock::now() - since_ : Clock::duration();
  return std::chrono::duration<double>(total_ + now).count();
}

OwnDevice::~OwnDevice() {
  const Functions& vk = device_.vk;
  if (device_.handle != VK_NULL_HANDLE) {
    vk.DestroyPipelineCache(device_.handle, pipelineCache_, nullptr);
    vk.DestroyDevice(device_.handle, nullptr);
  }
  if (device_.instance != VK_NULL_HANDLE) {
    if (messenger_ != VK_NULL_HANDLE) {
      const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
          vk.GetInstanceProcAddr(device_.instance, "vkDestroyDebugUtilsMessengerEXT"));
      destroy(device_.instance, messenger_, nullptr);
    }
    // Null when loading the instance's functions failed.
    if (vk.DestroyInstance != nullptr) vk.DestroyInstance(device_.instance, nullptr);
  }
}

Result<void> OwnDevice::open(const HeadlessDef& def) {
  if (Result<void> done = device_.vk.loadGlobal(nullptr); !done) return done;
  if (Result<void> done = createInstance(def); !done) return done;
  if (Result<void> done = choosePhysicalDevice(def); !done) return done;
  return createDevice(def.queues);
}

void OwnDevice::waitIdle() {
  for (OwnQueue& queue : queues_) queue.mutex.lock();
  static_cast<void>(device_.vk.DeviceWaitIdle(device_.handle));
  for (OwnQueue& queue : queues_) queue.mutex.unlock();
}

Result<void> OwnDevice::createInstance(const HeadlessDef& def) {
  Functions& vk = device_.vk;
  if (Result<void> checked = checkLoader(vk); !checked) return checked;
  auto application = tagged<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "pelage";
  application.pEngineName = "pelage";
  application.apiVersion = VK_API_VERSION_1_1;
  auto info = tagged<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pApplicationInfo = &application;

  std::vector<const char*> extensions;
  VkDebugUtilsMessengerCreateInfoEXT messenger = messengerInfo(messages_);
  const VkValidationFeatureEnableEXT enables[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  auto features = tagged<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = static_cast<uint32_t>(std::size(enables));
  features.pEnabledValidationFeatures = enables;

  if (def.validation) {
    Result<std::vector<const char*>> wanted = validationExtensions(vk);
    if (!wanted) return wanted.error();
    extensions = *std::move(wanted);
    debugUtils_ = true;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    messenger.pNext = &features;
    info.pNext = &messenger;
  }
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();

  const VkResult result = vk.CreateInstance(&info, nullptr, &device_.instance);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {
    return Error{
        ErrorCode::kUnsupported,
        "no Vulkan driver can be loaded (VK_LOADER_DEBUG=all says why). On Debian: apt-get "
        "install mesa-vulkan-drivers, or the driver of the GPU"};
  }
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateInstance");
  if (Result<void> loaded = vk.loadInstance(device_.instance); !loaded) return loaded;

  if (def.validation) {
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vk.GetInstanceProcAddr(device_.instance, "vkCreateDebugUtilsMessengerEXT"));
    messenger.pNext = nullptr;
    const VkResult made = create(device_.instance, &messenger, nullptr, &messenger_);
    if (made != VK_SUCCESS) return vulkanError(made, "vkCreateDebugUtilsMessengerEXT");
  }
  return {};
}

Result<void> OwnDevice::choosePhysicalDevice(const HeadlessDef& def) {
  const Functions& vk = device_.vk;
  const Result<std::vector<VkPhysicalDevice>> devices = physicalDevicesOf(device_);
  if (!devices) return devices.error();
  const Result<VkPhysicalDevice> picked = pickDevice(vk, *devices, def);
  if (!picked) return picked.error();
  device_.physical = *picked;
  vk.GetPhysicalDeviceProperties(device_.physical, &device_.properties);
  vk.GetPhysicalDeviceMemoryProperties(device_.physical, &device_.memory);
  device_.maxAllocation = UINT64_MAX;  // readbacks are small
  if (device_.properties.apiVersion < VK_API_VERSION_1_1) {
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("{} has Vulkan {}, 1.1 is needed: update its driver",
                    device_.properties.deviceName, versionText(device_.properties.apiVersion))};
  }
  return {};
}

Result<void> OwnDevice::createDevice(uint32_t queues) {
  Functions& vk = device_.vk;
  uint32_t count = 0;
  vk.GetPhysicalDeviceQueueFamilyProperties(device_.physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.GetPhysicalDeviceQueueFamilyProperties(device_.physical, &count, families.data());
  const auto familyWith = [&](VkQueueFlags flags) {
    const auto found = std::find_if(families.begin(), families.end(), [&](const auto& family) {
      return (family.queueFlags & flags) == flags;
    });
    return static_cast<uint32_t>(found - families.begin());
  };
  // A device that only computes is of use for execute().
  device_.queueFamily = familyWith(VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT);
  if (device_.queueFamily == count) device_.queueFamily = familyWith(VK_QUEUE_COMPUTE_BIT);
  if (device_.queueFamily == count) {
    return Error{ErrorCode::kUnsupported, fmt::format("{} has no queue family that computes",
                                                      device_.properties.deviceName)};
  }
  device_.queue = families[device_.queueFamily];

  VkPhysicalDeviceFeatures supported = {};
  vk.GetPhysicalDeviceFeatures(device_.physical, &supported);
  device_.features.fragmentStoresAndAtomics = supported.fragmentStoresAndAtomics;
  device_.features.vertexPipelineStoresAndAtomics = supported.vertexPipelineStoresAndAtomics;
  device_.features.fullDrawIndexUint32 = supported.fullDrawIndexUint32;

  const uint32_t queueCount = std::clamp(queues, 1u, device_.queue.queueCount);
  const std::vector<float> priorities(queueCount, 1.0f);
  auto queue = tagged<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = device_.queueFamily;
  queue.queueCount = queueCount;
  queue.pQueuePriorities = priorities.data();
  auto info = tagged<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.pEnabledFeatures = &device_.features;
  VkDevice created = VK_NULL_HANDLE;
  const VkResult result = vk.CreateDevice(device_.physical, &info, nullptr, &created);
  if (result != VK_SUCCESS) {
    return vulkanError(result, fmt::format("vkCreateDevice on {}", device_.properties.deviceName));
  }
  if (Result<void> loaded = vk.loadDevice(device_.instance, created, debugUtils_); !loaded) {
    const auto destroy =
        reinterpret_cast<PFN_vkDestroyDevice>(vk.GetDeviceProcAddr(created, "vkDestroyDevice"));
    if (destroy != nullptr) destroy(created, nullptr);
    return loaded;
  }
  device_.handle = created;
  for (uint32_t i = 0; i < queueCount; ++i)
    vk.GetDeviceQueue(created, device_.queueFamily, i, &queues_.emplace_back().handle);
  const auto cache =
      tagged<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  const VkResult cached = vk.CreatePipelineCache(created, &cache, nullptr, &pipelineCache_);
  if (cached != VK_SUCCESS) return vulkanError(cached, "vkCreatePipelineCache");
  return {};
}

DeviceInfo describe(const Device& device) {
  const Functions& vk = device.vk;
  uint32_t count = 0;
  std::vector<VkExtensionProperties> extensions;
  if (vk.EnumerateDeviceExtensionProperties(device.physical, nullptr, &count, nullptr) ==
      VK_SUCCESS) {
    extensions.resize(count);
    static_cast<void>(
        vk.EnumerateDeviceExtensionProperties(device.physical, nullptr, &count, extensions.data()));
    extensions.resize(count);
  }
  auto driver =
      tagged<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  if (hasExtension(extensions, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) {
    auto properties =
        tagged<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    properties.pNext = &driver;
    vk.GetPhysicalDeviceProperties2(device.physical, &properties);
  }
  DeviceInfo info;
  info.api = Api::kVulkan;
  info.name = device.properties.deviceName;
  info.driver = driver.driverName[0] != '\0'
                    ? fmt::format("{} {}", driver.driverName, driver.driverInfo)
                    : fmt::format("driver version {:#x}", device.properties.driverVersion);
  info.version = versionText(device.properties.apiVersion);
  info.uuid = uuidOf(vk, device.physical);
  info.software = device.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info.maxBufferBytes = device.properties.limits.maxStorageBufferRange;
  return info;
}

}  // namespace pelage::vulkan
