// A Vulkan device without a window: makes instance, device and queue, runs pass lists through the
// runtime, waits, and reads results back.

#include "pelage/headless.h"
#include "pelage/list_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "buffer_memory.h"
#include "device.h"
#include "pelage/vulkan.h"
#include "render_target.h"
#include "texture.h"

namespace pelage {
namespace vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr uint32_t kMaxTargetSize = 16384;
/// Bytes of a read that are staged at once.
constexpr VkDeviceSize kMaxReadback = VkDeviceSize{64} << 20;

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void* user) {
  static_cast<std::atomic<uint32_t>*>(user)->fetch_add(1);
  const bool error = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  std::fprintf(stderr, "pelage: Vulkan %s: %s\n", error ? "error" : "warning", data->pMessage);
  return VK_FALSE;
}

// The widening is exact: every half is a float.
float halfToFloat(uint16_t half) {
  const uint32_t sign = static_cast<uint32_t>(half & 0x8000u) << 16;
  const uint32_t exponent = half >> 10 & 0x1fu;
  const uint32_t mantissa = half & 0x3ffu;
  if (exponent == 0x1f) return std::bit_cast<float>(sign | 0x7f800000u | mantissa << 13);
  if (exponent != 0)
    return std::bit_cast<float>(sign | (exponent + (127 - 15)) << 23 | mantissa << 13);
  const float value = static_cast<float>(mantissa) * 0x1p-24f;  // subnormal
  return sign != 0 ? -value : value;
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

class HeadlessVulkan final : public HeadlessDevice {
 public:
  HeadlessVulkan() = default;
  ~HeadlessVulkan() override;

  Result<void> open(const HeadlessDef& def);

  const DeviceInfo& info() const override { return info_; }
  Result<void> update(const ResourceTable& resources) override;
  Result<TextureId> createTexture(const TextureDef& texture) override;
  Result<void> execute(const PassList& list, std::vector<PassTiming>* timings) override;
  using HeadlessDevice::render;
  Result<RenderedImage> render(std::span<const PassList* const> lists,
                               const RenderTargetDef& target,
                               std::vector<PassTiming>* timings) override;
  Result<std::vector<std::byte>> read(BufferId buffer, uint64_t offset, uint64_t size) override;
  using HeadlessDevice::supports;
  Result<void> supports(const PassList& list) const override { return runtime_->supports(list); }
  void addCode(KernelCodeList code) override { runtime_->addCode(code); }
  uint64_t bufferBytes() const override { return runtime_->bufferBytes(); }
  uint32_t messageCount() const override { return messages_.load(); }

 private:
  Result<void> createInstance(const HeadlessDef& def);
  Result<void> choosePhysicalDevice(const HeadlessDef& def);
  Result<void> createDevice();
  Result<void> describe();
  uint32_t sampleCounts(VkFormat color) const;

  /// Starts a frame and its command buffer.
  Result<void> begin();
  /// Ends, submits, waits.
  Result<void> submit();
  /// Takes back a command buffer that was not submitted.
  void abandon();

  Result<void> makeTarget(const RenderTargetDef& def);
  /// Records one list of render(): all but the first load what is there.
  Result<void> recordList(const PassList& list, const RenderTargetDef& def, const VkRect2D& area,
                          bool first);

  std::atomic<uint32_t> messages_{0};
  DeviceInfo info_;
  Device device_;
  bool debugUtils_ = false;
  Tier maxTier_ = Tier::kWide;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  uint64_t frame_ = 0;
  std::unique_ptr<BufferMemory> memory_;  // of readbacks
  std::optional<Runtime> runtime_;
  RenderTarget target_{device_};
  std::vector<Texture> textures_;
};

HeadlessVulkan::~HeadlessVulkan() {
  const Functions& vk = device_.vk;
  if (device_.handle != VK_NULL_HANDLE) {
    static_cast<void>(vk.DeviceWaitIdle(device_.handle));
    if (runtime_) runtime_->forget(target_.renderPass());
    target_.destroy();
    for (Texture& texture : textures_) texture.destroy(device_);
    runtime_.reset();
    memory_.reset();
    vk.DestroyFence(device_.handle, fence_, nullptr);
    vk.DestroyCommandPool(device_.handle, pool_, nullptr);
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

Result<void> HeadlessVulkan::open(const HeadlessDef& def) {
  if (def.api != Api::kVulkan) {
    return Error{ErrorCode::kInvalidArgument,
                 "createHeadlessVulkan() makes Vulkan devices: use createHeadlessGl()"};
  }
  maxTier_ = def.maxTier;
  if (Result<void> done = device_.vk.loadGlobal(nullptr); !done) return done;
  if (Result<void> done = createInstance(def); !done) return done;
  if (Result<void> done = choosePhysicalDevice(def); !done) return done;
  if (Result<void> done = createDevice(); !done) return done;
  return describe();
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

Result<void> HeadlessVulkan::createInstance(const HeadlessDef& def) {
  Functions& vk = device_.vk;
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

  auto application = tagged<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "pelage";
  application.pEngineName = "pelage";
  application.apiVersion = VK_API_VERSION_1_1;
  auto info = tagged<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pApplicationInfo = &application;

  std::vector<const char*> extensions;
  auto messenger = tagged<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  // Not the general ones: the loader reports every driver that is installed without its device.
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                          VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = onMessage;
  messenger.pUserData = &messages_;
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

Result<void> HeadlessVulkan::choosePhysicalDevice(const HeadlessDef& def) {
  int index = def.deviceIndex;
  const Functions& vk = device_.vk;
  uint32_t count = 0;
  VkResult result = vk.EnumeratePhysicalDevices(device_.instance, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  if (result == VK_SUCCESS && count > 0)
    result = vk.EnumeratePhysicalDevices(device_.instance, &count, devices.data());
  if (result != VK_SUCCESS && result != VK_ERROR_INITIALIZATION_FAILED)
    return vulkanError(result, "vkEnumeratePhysicalDevices");
  if (devices.empty()) {
    return Error{ErrorCode::kUnsupported,
                 "no Vulkan device. On Debian: apt-get install mesa-vulkan-drivers (a software "
                 "driver is among them), or the driver of the GPU"};
  }

  const auto rank = [](VkPhysicalDeviceType type) {
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
  };
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
    const int here = rank(properties.deviceType);
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
  device_.physical = devices[static_cast<size_t>(best)];
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

Result<void> HeadlessVulkan::createDevice() {
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

  const float priority = 1;
  auto queue = tagged<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = device_.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  auto info = tagged<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.pEnabledFeatures = &device_.features;
  VkDevice created = VK_NULL_HANDLE;
  VkResult result = vk.CreateDevice(device_.physical, &info, nullptr, &created);
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
  vk.GetDeviceQueue(created, device_.queueFamily, 0, &queue_);

  auto pool = tagged<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.queueFamilyIndex = device_.queueFamily;
  result = vk.CreateCommandPool(created, &pool, nullptr, &pool_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateCommandPool");
  auto buffers =
      tagged<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  buffers.commandPool = pool_;
  buffers.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffers.commandBufferCount = 1;
  result = vk.AllocateCommandBuffers(created, &buffers, &commands_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkAllocateCommandBuffers");
  const auto fence = tagged<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  result = vk.CreateFence(created, &fence, nullptr, &fence_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkCreateFence");

  memory_ = std::make_unique<BufferMemory>(device_, BufferAllocator{});
  RuntimeDef def;
  def.instance = device_.instance;
  def.physicalDevice = device_.physical;
  def.device = created;
  def.queueFamily = device_.queueFamily;
  def.enabledFeatures = device_.features;
  def.getInstanceProcAddr = vk.GetInstanceProcAddr;
  def.debugUtils = debugUtils_;
  def.maxTier = maxTier_;
  Result<Runtime> runtime = Runtime::create(def);
  if (!runtime) return runtime.error();
  runtime_.emplace(*std::move(runtime));
  return {};
}

Result<void> HeadlessVulkan::describe() {
  const Functions& vk = device_.vk;
  uint32_t count = 0;
  std::vector<VkExtensionProperties> extensions;
  if (vk.EnumerateDeviceExtensionProperties(device_.physical, nullptr, &count, nullptr) ==
      VK_SUCCESS) {
    extensions.resize(count);
    static_cast<void>(vk.EnumerateDeviceExtensionProperties(device_.physical, nullptr, &count,
                                                            extensions.data()));
    extensions.resize(count);
  }
  auto driver =
      tagged<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  if (hasExtension(extensions, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME)) {
    auto properties =
        tagged<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    properties.pNext = &driver;
    vk.GetPhysicalDeviceProperties2(device_.physical, &properties);
  }
  info_.api = Api::kVulkan;
  info_.name = device_.properties.deviceName;
  info_.driver = driver.driverName[0] != '\0'
                     ? fmt::format("{} {}", driver.driverName, driver.driverInfo)
                     : fmt::format("driver version {:#x}", device_.properties.driverVersion);
  info_.version = versionText(device_.properties.apiVersion);
  info_.uuid = uuidOf(vk, device_.physical);
  info_.software = device_.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  info_.sampleCounts = sampleCounts(RenderTarget::kColorFormat);
  info_.maxSamples = std::bit_floor(info_.sampleCounts);
  info_.maxBufferBytes = device_.properties.limits.maxStorageBufferRange;
  info_.tier = runtime_->tier();
  return {};
}

uint32_t HeadlessVulkan::sampleCounts(VkFormat color) const {
  const auto counts = [&](VkFormat format, VkImageUsageFlags usage) -> VkSampleCountFlags {
    VkImageFormatProperties properties = {};
    const VkResult result = device_.vk.GetPhysicalDeviceImageFormatProperties(
        device_.physical, format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, usage, 0, &properties);
    return result == VK_SUCCESS ? properties.sampleCounts : 0;
  };
  const VkSampleCountFlags both =
      counts(color, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) &
      counts(RenderTarget::kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) &
      device_.limits().framebufferColorSampleCounts & device_.limits().framebufferDepthSampleCounts;
  return (both & 15u) | 1u;
}

Result<void> HeadlessVulkan::begin() {
  const Functions& vk = device_.vk;
  VkResult result = vk.ResetCommandPool(device_.handle, pool_, 0);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetCommandPool");
  auto info = tagged<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  result = vk.BeginCommandBuffer(commands_, &info);
  if (result != VK_SUCCESS) return vulkanError(result, "vkBeginCommandBuffer");
  // Each call waits for its frame, so all earlier ones have completed.
  runtime_->beginFrame(frame_ + 1, frame_);
  ++frame_;
  return {};
}

Result<void> HeadlessVulkan::submit() {
  const Functions& vk = device_.vk;
  VkResult result = vk.EndCommandBuffer(commands_);
  if (result != VK_SUCCESS) {
    runtime_->abandonFrame();
    return vulkanError(result, "vkEndCommandBuffer");
  }
  auto info = tagged<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  result = vk.QueueSubmit(queue_, 1, &info, fence_);
  if (result != VK_SUCCESS) {
    runtime_->abandonFrame();
    return vulkanError(result, "vkQueueSubmit");
  }
  runtime_->submitted();
  result = vk.WaitForFences(device_.handle, 1, &fence_, VK_TRUE, UINT64_MAX);
  if (result != VK_SUCCESS) return vulkanError(result, "vkWaitForFences");
  result = vk.ResetFences(device_.handle, 1, &fence_);
  if (result != VK_SUCCESS) return vulkanError(result, "vkResetFences");
  runtime_->collect(frame_);
  return {};
}

void HeadlessVulkan::abandon() {
  static_cast<void>(device_.vk.EndCommandBuffer(commands_));
  runtime_->abandonFrame();
  runtime_->collect(frame_);
}

Result<void> HeadlessVulkan::update(const ResourceTable& resources) {
  return guarded([&]() -> Result<void> {
    if (Result<void> done = begin(); !done) return done;
    if (Result<void> done = runtime_->update(resources, commands_); !done) {
      abandon();
      return done;
    }
    return submit();
  });
}

Result<TextureId> HeadlessVulkan::createTexture(const TextureDef& def) {
  return guarded([&]() -> Result<TextureId> {
    const Result<std::vector<std::byte>> texels = textureBytes(def);
    if (!texels) return texels.error();
    textures_.reserve(textures_.size() + 1);
    Texture texture;
    if (Result<void> made = texture.make(device_, def); !made) return made.error();
    textures_.push_back(texture);
    Result<AllocatedBuffer> staging = memory_->create(
        texels->size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::kStaging, "pelage/texels");
    if (!staging) return staging.error();
    std::memcpy(staging->mapped, texels->data(), texels->size());
    Result<void> done = begin();
    if (done) {
      texture.fill(device_, commands_, staging->buffer);
      done = submit();
    }
    memory_->destroy(*staging);
    if (!done) return done.error();
    const TextureId id = newTextureId();
    runtime_->registerTexture(id, texture.external());
    return id;
  });
}

Result<void> HeadlessVulkan::execute(const PassList& list, std::vector<PassTiming>* timings) {
  return guarded([&]() -> Result<void> {
    if (timings != nullptr) timings->clear();
    if (Result<void> done = begin(); !done) return done;
    runtime_->setTimestamps(timings != nullptr);
    if (Result<void> done = runtime_->record(list, commands_); !done) {
      abandon();
      return done;
    }
    if (Result<void> done = submit(); !done) return done;
    if (timings != nullptr) *timings = runtime_->timings(frame_);
    return {};
  });
}

Result<void> HeadlessVulkan::makeTarget(const RenderTargetDef& def) {
  if (def.width < 1 || def.width > kMaxTargetSize || def.height < 1 ||
      def.height > kMaxTargetSize) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a target of {} x {} pixels; both are 1 to {}", def.width, def.height,
                             kMaxTargetSize)};
  }
  if (!std::has_single_bit(def.samples) || def.samples > 8) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} samples a pixel; they are 1, 2, 4 or 8", def.samples)};
  }
  const VkPhysicalDeviceLimits& limits = device_.limits();
  const uint32_t largest = std::min(
      {limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxFramebufferHeight});
  if (std::max(def.width, def.height) > largest) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("a target of {} x {} pixels; {} draws at most {}", def.width,
                             def.height, info_.name, largest)};
  }
  const uint32_t counts =
      def.float32Color ? sampleCounts(RenderTarget::formatOf(def)) : info_.sampleCounts;
  if ((counts & def.samples) == 0) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{} samples a pixel: {} has no such target; it has up to {}",
                             def.samples, info_.name, info_.maxSamples)};
  }
  if ((device_.queue.queueFlags & VK_QUEUE_GRAPHICS_BIT) == 0) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{} has no queue that draws; it can only compute", info_.name)};
  }
  if (target_.fits(def)) return {};
  runtime_->forget(target_.renderPass());
  return target_.make(def);
}

Result<void> HeadlessVulkan::recordList(const PassList& list, const RenderTargetDef& def,
                                        const VkRect2D& area, bool first) {
  if (Result<void> done = runtime_->record(list, commands_); !done) return done;
  const bool draws = std::any_of(list.passes.begin(), list.passes.end(),
                                 [](const Pass& pass) { return isDraw(pass.kind); });
  if (!first && !draws) return {};
  target_.begin(commands_, def, first);
  Result<void> drawn = runtime_->recordDraws(list, commands_, target_.formats(), area);
  device_.vk.CmdEndRenderPass(commands_);
  return drawn;
}

Result<RenderedImage> HeadlessVulkan::render(std::span<const PassList* const> lists,
                                             const RenderTargetDef& def,
                                             std::vector<PassTiming>* timings) {
  return guarded([&]() -> Result<RenderedImage> {
    if (timings != nullptr) timings->clear();
    if (Result<void> made = makeTarget(def); !made) return made.error();
    const Result<PixelArea> drawn = drawArea(def);
    if (!drawn) return drawn.error();
    for (const PassList* list : lists) {
      if (Result<void> fits = checkArea(*list, *drawn); !fits) return fits.error();
    }
    const VkRect2D area = {{static_cast<int32_t>(drawn->x), static_cast<int32_t>(drawn->y)},
                           {drawn->width, drawn->height}};
    const uint64_t depthBytes = runtime_->buffer(def.depthCopy).size;
    if (Result<void> ok = checkDepthCopy(def, lists.size(), depthBytes); !ok) return ok.error();
    const size_t pixelBytes = 4 * (def.float32Color ? sizeof(float) : sizeof(uint16_t));
    const size_t pixels = size_t{def.width} * def.height;
    RenderedImage image{def.width, def.height, std::vector<Float4>(pixels)};
    Result<AllocatedBuffer> readback =
        memory_->create(pixels * pixelBytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                        MemoryKind::kReadback, "pelage/readback");
    if (!readback) return readback.error();
    const auto release = [&](const Error& error) -> Result<RenderedImage> {
      memory_->destroy(*readback);
      return error;
    };

    if (Result<void> done = begin(); !done) return release(done.error());
    runtime_->setTimestamps(timings != nullptr);
    const PassList none;
    const PassList* const nothing[] = {&none};
    if (lists.empty()) lists = nothing;  // still clears
    for (size_t i = 0; i < lists.size(); ++i) {
      if (Result<void> done = recordList(*lists[i], def, area, i == 0); !done) {
        abandon();
        return release(done.error());
      }
      if (def.depthCopy != BufferId::kInvalid && i == def.depthCopyAfter)
        target_.copyDepth(commands_, area, runtime_->buffer(def.depthCopy));
    }
    target_.copyColor(commands_, readback->buffer);
    if (Result<void> done = submit(); !done) return release(done.error());
    if (timings != nullptr) *timings = runtime_->timings(frame_);

    const auto* bytes = static_cast<const std::byte*>(readback->mapped);
    static_assert(sizeof(Float4) == 4 * sizeof(float));
    if (def.float32Color) std::memcpy(image.pixels.data(), bytes, pixels * pixelBytes);
    for (size_t i = 0; i < pixels && !def.float32Color; ++i) {
      std::array<uint16_t, 4> texel;
      std::memcpy(texel.data(), bytes + i * pixelBytes, pixelBytes);
      image.pixels[i] = {halfToFloat(texel[0]), halfToFloat(texel[1]), halfToFloat(texel[2]),
                         halfToFloat(texel[3])};
    }
    memory_->destroy(*readback);
    return image;
  });
}

Result<std::vector<std::byte>> HeadlessVulkan::read(BufferId buffer, uint64_t offset,
                                                    uint64_t size) {
  return guarded([&]() -> Result<std::vector<std::byte>> {
    const Functions& vk = device_.vk;
    const BufferRange range = runtime_->buffer(buffer);
    if (range.buffer == VK_NULL_HANDLE) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("read of buffer #{}, which was removed or which update() has not "
                               "seen",
                               static_cast<uint32_t>(buffer))};
    }
    if (offset > range.size || size > range.size - offset) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("read of bytes {} to {} of a buffer of {}", offset, offset + size,
                               range.size)};
    }
    if (size == 0) size = range.size - offset;
    std::vector<std::byte> data(static_cast<size_t>(size));
    if (size == 0) return data;
    const VkDeviceSize piece = std::min(size, kMaxReadback);
    Result<AllocatedBuffer> readback = memory_->create(piece, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                                       MemoryKind::kReadback, "pelage/readback");
    if (!readback) return readback.error();
    for (VkDeviceSize at = 0; at < size; at += piece) {
      const VkDeviceSize length = std::min(piece, size - at);
      Result<void> done = begin();
      if (done) {
        auto before = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
        before.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
        before.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
        vk.CmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                              VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &before, 0, nullptr, 0,
                              nullptr);
        const VkBufferCopy copy = {range.offset + offset + at, 0, length};
        vk.CmdCopyBuffer(commands_, range.buffer, readback->buffer, 1, &copy);
        auto after = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
        after.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        after.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vk.CmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                              0, 1, &after, 0, nullptr, 0, nullptr);
        done = submit();
      }
      if (!done) {
        memory_->destroy(*readback);
        return done.error();
      }
      std::memcpy(data.data() + at, readback->mapped, static_cast<size_t>(length));
    }
    memory_->destroy(*readback);
    return data;
  });
}

}  // namespace
}  // namespace vulkan

Result<std::unique_ptr<HeadlessDevice>> createHeadlessVulkan(const HeadlessDef& def) {
  return vulkan::guarded([&]() -> Result<std::unique_ptr<HeadlessDevice>> {
    auto device = std::make_unique<vulkan::HeadlessVulkan>();
    if (Result<void> opened = device->open(def); !opened) return opened.error();
    return std::unique_ptr<HeadlessDevice>(std::move(device));
  });
}

}  // namespace pelage
