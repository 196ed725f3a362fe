#include "vulkan_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace runtime_test {
namespace {

void check(VkResult result, const char* what) {
  if (result != VK_SUCCESS) ADD_FAILURE() << what << ": VkResult " << result;
}

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void* user) {
  static_cast<std::atomic<uint32_t>*>(user)->fetch_add(1);
  std::fprintf(stderr, "%s\n", data->pMessage);
  return VK_FALSE;
}

bool hasAll(VkPhysicalDevice device, const std::vector<const char*>& names) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> there(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, there.data());
  return std::ranges::all_of(names, [&](std::string_view name) {
    return std::ranges::any_of(there, [&](const auto& one) { return name == one.extensionName; });
  });
}

}  // namespace

std::unique_ptr<Engine> Engine::create(std::string& reason,
                                       const VkPhysicalDeviceFeatures& features, bool validates,
                                       const DeviceExtensions& extensions) {
  std::unique_ptr<Engine> engine(new Engine);
  engine->features_ = features;
  return engine->open(reason, validates, extensions) ? std::move(engine) : nullptr;
}

bool Engine::open(std::string& reason, bool validates, const DeviceExtensions& extensions) {
  auto application = tagged<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.apiVersion = VK_API_VERSION_1_3;
  auto messenger = tagged<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  messenger.pUserData = &messages_;
  const VkValidationFeatureEnableEXT enable =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  auto validation = tagged<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  validation.enabledValidationFeatureCount = 1;
  validation.pEnabledValidationFeatures = &enable;
  if (validates) messenger.pNext = &validation;
  const char* layer = "VK_LAYER_KHRONOS_validation";
  const char* ofInstance[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                              VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  auto info = tagged<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pNext = &messenger;
  info.pApplicationInfo = &application;
  info.enabledLayerCount = validates ? 1 : 0;
  info.ppEnabledLayerNames = &layer;
  info.enabledExtensionCount = validates ? 2 : 1;
  info.ppEnabledExtensionNames = ofInstance;
  if (vkCreateInstance(&info, nullptr, &instance_) != VK_SUCCESS) {
    reason = "no Vulkan instance with the validation layer";
    return false;
  }
  messenger.pNext = nullptr;
  const auto createMessenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  check(createMessenger(instance_, &messenger, nullptr, &messenger_), "messenger");

  // The same choice as the headless device: a GPU before a software driver.
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance_, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance_, &count, devices.data());
  for (const VkPhysicalDevice candidate : devices) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(candidate, &properties);
    const bool software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    if (physical_ != VK_NULL_HANDLE && software) continue;
    physical_ = candidate;
    properties_ = properties;
  }
  if (physical_ == VK_NULL_HANDLE) {
    reason = "no Vulkan device";
    return false;
  }
  VkPhysicalDeviceFeatures there = {};
  vkGetPhysicalDeviceFeatures(physical_, &there);
  features_.independentBlend = features_.independentBlend & there.independentBlend;
  features_.fragmentStoresAndAtomics =
      features_.fragmentStoresAndAtomics & there.fragmentStoresAndAtomics;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
  const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto family = std::find_if(families.begin(), families.end(), [&](const auto& candidate) {
    return (candidate.queueFlags & both) == both;
  });
  if (family == families.end()) {
    reason = "no queue family that draws and computes";
    return false;
  }
  family_ = static_cast<uint32_t>(family - families.begin());
  const auto compute = std::find_if(families.begin(), families.end(), [&](const auto& candidate) {
    return (candidate.queueFlags & both) == VK_QUEUE_COMPUTE_BIT;
  });
  computeFamily_ =
      static_cast<uint32_t>((compute != families.end() ? compute : family) - families.begin());

  const float priority = 1;
  std::vector<VkDeviceQueueCreateInfo> queues;
  for (const uint32_t each : {family_, computeFamily_}) {
    if (!queues.empty() && each == family_) break;
    queues.push_back(tagged<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO));
    queues.back().queueFamilyIndex = each;
    queues.back().queueCount = 1;
    queues.back().pQueuePriorities = &priority;
  }
  auto rendering = tagged<VkPhysicalDeviceDynamicRenderingFeatures>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES);
  rendering.dynamicRendering = VK_TRUE;
  dynamicRendering_ = properties_.apiVersion >= VK_API_VERSION_1_3;
  auto device = tagged<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  hasExtensions_ = hasAll(physical_, extensions.names);
  if (hasExtensions_) {
    rendering.pNext = extensions.features;
    device.pNext = extensions.features;
    device.enabledExtensionCount = static_cast<uint32_t>(extensions.names.size());
    device.ppEnabledExtensionNames = extensions.names.data();
  }
  if (dynamicRendering_) device.pNext = &rendering;
  device.queueCreateInfoCount = static_cast<uint32_t>(queues.size());
  device.pQueueCreateInfos = queues.data();
  device.pEnabledFeatures = &features_;
  if (vkCreateDevice(physical_, &device, nullptr, &device_) != VK_SUCCESS) {
    reason = "the Vulkan device cannot be made";
    return false;
  }
  vkGetDeviceQueue(device_, family_, 0, &queue_);
  vkGetDeviceQueue(device_, computeFamily_, 0, &computeQueue_);
  return true;
}

Engine::~Engine() {
  if (device_ != VK_NULL_HANDLE) {
    vkDeviceWaitIdle(device_);
    vkDestroyDevice(device_, nullptr);
  }
  if (instance_ == VK_NULL_HANDLE) return;
  const auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
  if (messenger_ != VK_NULL_HANDLE) destroyMessenger(instance_, messenger_, nullptr);
  vkDestroyInstance(instance_, nullptr);
}

pelage::vulkan::RuntimeDef Engine::runtimeDef() const {
  pelage::vulkan::RuntimeDef def;
  def.instance = instance_;
  def.physicalDevice = physical_;
  def.device = device_;
  def.queueFamily = family_;
  def.enabledFeatures = features_;
  def.getInstanceProcAddr = vkGetInstanceProcAddr;
  def.debugUtils = true;
  return def;
}

EngineBuffer Engine::createBuffer(VkDeviceSize size, VkBufferUsageFlags usage,
                                  bool hostVisible) const {
  EngineBuffer buffer;
  auto info = tagged<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = usage;
  check(vkCreateBuffer(device_, &info, nullptr, &buffer.buffer), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer.buffer, &needs);
  VkPhysicalDeviceMemoryProperties types;
  vkGetPhysicalDeviceMemoryProperties(physical_, &types);
  const VkMemoryPropertyFlags wanted =
      hostVisible ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                  : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  auto allocate = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  allocate.allocationSize = needs.size;
  auto flags = tagged<VkMemoryAllocateFlagsInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  if ((usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0) allocate.pNext = &flags;
  for (uint32_t type = 0; type < types.memoryTypeCount; ++type) {
    if ((needs.memoryTypeBits >> type & 1u) == 0) continue;
    if ((types.memoryTypes[type].propertyFlags & wanted) != wanted) continue;
    allocate.memoryTypeIndex = type;
    break;
  }
  check(vkAllocateMemory(device_, &allocate, nullptr, &buffer.memory), "vkAllocateMemory");
  check(vkBindBufferMemory(device_, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory");
  if (hostVisible) {
    check(vkMapMemory(device_, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory");
  }
  return buffer;
}

void Engine::destroyBuffer(const EngineBuffer& buffer) const {
  vkDestroyBuffer(device_, buffer.buffer, nullptr);
  vkFreeMemory(device_, buffer.memory, nullptr);
}

EngineImage Engine::createImage(VkFormat format, VkImageAspectFlags aspects, uint32_t size) const {
  EngineImage made = {.format = format, .aspects = aspects};
  auto info = tagged<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {size, size, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  info.usage |= aspects == VK_IMAGE_ASPECT_COLOR_BIT ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                                     : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  check(vkCreateImage(device_, &info, nullptr, &made.image), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device_, made.image, &needs);
  auto allocate = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  allocate.allocationSize = needs.size;
  while ((needs.memoryTypeBits >> allocate.memoryTypeIndex & 1u) == 0) ++allocate.memoryTypeIndex;
  check(vkAllocateMemory(device_, &allocate, nullptr, &made.memory), "vkAllocateMemory");
  check(vkBindImageMemory(device_, made.image, made.memory, 0), "vkBindImageMemory");
  auto view = tagged<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = made.image;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {aspects, 0, 1, 0, 1};
  check(vkCreateImageView(device_, &view, nullptr, &made.view), "vkCreateImageView");
  return made;
}

void Engine::destroyImage(const EngineImage& image) const {
  vkDestroyImageView(device_, image.view, nullptr);
  vkDestroyImage(device_, image.image, nullptr);
  vkFreeMemory(device_, image.memory, nullptr);
}

std::vector<std::byte> Engine::read(const pelage::vulkan::BufferRange& range,
                                    const Frame& frame) const {
  const EngineBuffer out = createBuffer(range.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, true);
  begin(frame);
  auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  vkCmdPipelineBarrier(frame.commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
  const VkBufferCopy copy = {range.offset, 0, range.size};
  vkCmdCopyBuffer(frame.commands, range.buffer, out.buffer, 1, &copy);
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(frame.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                       0, 1, &barrier, 0, nullptr, 0, nullptr);
  submit(frame);
  wait(frame);
  std::vector<std::byte> bytes(range.size);
  std::memcpy(bytes.data(), out.mapped, bytes.size());
  destroyBuffer(out);
  return bytes;
}

Engine::Frame Engine::createFrame(uint32_t queueFamily) const {
  Frame frame;
  auto pool = tagged<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.queueFamilyIndex = queueFamily;
  check(vkCreateCommandPool(device_, &pool, nullptr, &frame.pool), "vkCreateCommandPool");
  auto info = tagged<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  info.commandPool = frame.pool;
  info.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(device_, &info, &frame.commands), "vkAllocateCommandBuffers");
  auto fence = tagged<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
  check(vkCreateFence(device_, &fence, nullptr, &frame.fence), "vkCreateFence");
  return frame;
}

void Engine::destroyFrame(const Frame& frame) const {
  wait(frame);
  vkDestroyFence(device_, frame.fence, nullptr);
  vkDestroyCommandPool(device_, frame.pool, nullptr);
}

void Engine::wait(const Frame& frame) const {
  check(vkWaitForFences(device_, 1, &frame.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
}

void Engine::begin(const Frame& frame) const {
  wait(frame);
  check(vkResetFences(device_, 1, &frame.fence), "vkResetFences");
  check(vkResetCommandPool(device_, frame.pool, 0), "vkResetCommandPool");
  auto info = tagged<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(frame.commands, &info), "vkBeginCommandBuffer");
}

void Engine::discard(const Frame& frame) const {
  check(vkEndCommandBuffer(frame.commands), "vkEndCommandBuffer");
  check(vkQueueSubmit(queue_, 0, nullptr, frame.fence), "vkQueueSubmit");
}

void Engine::submit(const Frame& frame) const {
  check(vkEndCommandBuffer(frame.commands), "vkEndCommandBuffer");
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &frame.commands;
  check(vkQueueSubmit(queue_, 1, &info, frame.fence), "vkQueueSubmit");
}

}  // namespace runtime_test
