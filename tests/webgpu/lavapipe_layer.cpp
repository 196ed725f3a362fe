// A Vulkan layer for tests: Dawn refuses lavapipe of Mesa 22.3, which lacks two features that Dawn
// asks of every driver: dynamic indices into arrays of sampled and of storage images. No kernel has
// such arrays. The layer reports both, and takes them away again where a device is made.
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <cstring>
#include <map>
#include <mutex>

namespace {

// An instance, and functions of the layer below. They are looked up before the loader knows the
// instance: later it would return those of this layer.
struct Instance {
  VkInstance handle;
  PFN_vkGetInstanceProcAddr next;
  PFN_vkGetPhysicalDeviceFeatures features;
  PFN_vkGetPhysicalDeviceFeatures2 features2;
  PFN_vkCreateDevice createDevice;
};

std::mutex mutex;
std::map<void*, Instance> instances;               // by dispatch table
std::map<void*, PFN_vkGetDeviceProcAddr> devices;  // likewise

// An instance and its physical devices begin with the address of one dispatch table.
template <class Handle>
void* tableOf(Handle handle) {
  return *reinterpret_cast<void**>(handle);
}

template <class Handle>
Instance instanceOf(Handle handle) {
  const std::lock_guard lock(mutex);
  return instances.at(tableOf(handle));
}

void setMissing(VkPhysicalDeviceFeatures& features, VkBool32 value) {
  features.shaderSampledImageArrayDynamicIndexing = value;
  features.shaderStorageImageArrayDynamicIndexing = value;
}

// The loader's link of a chain of create infos.
template <class Link>
Link* linkOf(const void* chain, VkStructureType type) {
  for (auto* in = static_cast<const VkBaseInStructure*>(chain); in != nullptr; in = in->pNext) {
    auto* link = reinterpret_cast<const Link*>(in);
    if (in->sType == type && link->function == VK_LAYER_LINK_INFO) return const_cast<Link*>(link);
  }
  return nullptr;
}

VKAPI_ATTR VkResult VKAPI_CALL createInstance(const VkInstanceCreateInfo* info,
                                              const VkAllocationCallbacks* allocator,
                                              VkInstance* instance) {
  auto* link =
      linkOf<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetInstanceProcAddr gipa = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(gipa(nullptr, "vkCreateInstance"));
  const VkResult result = create(info, allocator, instance);
  if (result != VK_SUCCESS) return result;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(gipa(*instance, name));
  };
  Instance below = {*instance, gipa, nullptr, nullptr, nullptr};
  find(below.features, "vkGetPhysicalDeviceFeatures");
  find(below.features2, "vkGetPhysicalDeviceFeatures2");
  find(below.createDevice, "vkCreateDevice");
  const std::lock_guard lock(mutex);
  instances[tableOf(*instance)] = below;
  return result;
}

VKAPI_ATTR void VKAPI_CALL getFeatures(VkPhysicalDevice device, VkPhysicalDeviceFeatures* out) {
  instanceOf(device).features(device, out);
  setMissing(*out, VK_TRUE);
}

VKAPI_ATTR void VKAPI_CALL getFeatures2(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* out) {
  instanceOf(device).features2(device, out);
  setMissing(out->features, VK_TRUE);
}

VKAPI_ATTR VkResult VKAPI_CALL createDevice(VkPhysicalDevice physical,
                                            const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocator,
                                            VkDevice* device) {
  auto* link =
      linkOf<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
  const PFN_vkGetDeviceProcAddr gdpa = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  // Where the features are is the application's own memory, which it keeps.
  VkDeviceCreateInfo own = *info;
  VkPhysicalDeviceFeatures features = {};
  if (info->pEnabledFeatures != nullptr) {
    features = *info->pEnabledFeatures;
    setMissing(features, VK_FALSE);
    own.pEnabledFeatures = &features;
  }
  VkPhysicalDeviceFeatures2* chained = nullptr;
  for (auto* in = static_cast<const VkBaseInStructure*>(info->pNext); in != nullptr;
       in = in->pNext) {
    if (in->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2)
      chained = reinterpret_cast<VkPhysicalDeviceFeatures2*>(const_cast<VkBaseInStructure*>(in));
  }
  if (chained != nullptr) setMissing(chained->features, VK_FALSE);
  const VkResult result = instanceOf(physical).createDevice(physical, &own, allocator, device);
  if (chained != nullptr) setMissing(chained->features, VK_TRUE);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(mutex);
  devices[tableOf(*device)] = gdpa;
  return result;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getDeviceProcAddr(VkDevice device, const char* name) {
  const std::lock_guard lock(mutex);
  return devices.at(tableOf(device))(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL getInstanceProcAddr(VkInstance instance,
                                                             const char* name) {
  struct Own {
    const char* name;
    PFN_vkVoidFunction function;
  };
  const Own kOwn[] = {
      {"vkGetInstanceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getInstanceProcAddr)},
      {"vkGetDeviceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getDeviceProcAddr)},
      {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(createInstance)},
      {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(createDevice)},
      {"vkGetPhysicalDeviceFeatures", reinterpret_cast<PFN_vkVoidFunction>(getFeatures)},
      {"vkGetPhysicalDeviceFeatures2", reinterpret_cast<PFN_vkVoidFunction>(getFeatures2)},
      {"vkGetPhysicalDeviceFeatures2KHR", reinterpret_cast<PFN_vkVoidFunction>(getFeatures2)},
  };
  for (const Own& own : kOwn)
    if (std::strcmp(own.name, name) == 0) return own.function;
  if (instance == nullptr) return nullptr;
  return instanceOf(instance).next(instance, name);
}

}  // namespace

extern "C" VK_LAYER_EXPORT VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  version->loaderLayerInterfaceVersion = 2;
  version->pfnGetInstanceProcAddr = getInstanceProcAddr;
  version->pfnGetDeviceProcAddr = getDeviceProcAddr;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
