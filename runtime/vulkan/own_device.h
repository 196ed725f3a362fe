// Instance, device and queue that the headless device makes for itself.
#pragma once

#include <atomic>

#include "device.h"
#include "pelage/headless.h"

namespace pelage::vulkan {

class OwnDevice {
 public:
  OwnDevice() = default;
  ~OwnDevice();
  OwnDevice(const OwnDevice&) = delete;
  OwnDevice& operator=(const OwnDevice&) = delete;

  /// Errors: no loader, driver, device or queue as the definition asks for; validation is missing.
  Result<void> open(const HeadlessDef& def);

  const Device& device() const { return device_; }
  VkQueue queue() const { return queue_; }
  bool debugUtils() const { return debugUtils_; }
  /// Warnings and errors of validation so far.
  uint32_t messageCount() const { return messages_.load(); }

 private:
  Result<void> createInstance(const HeadlessDef& def);
  Result<void> choosePhysicalDevice(const HeadlessDef& def);
  Result<void> createDevice();

  Device device_;
  bool debugUtils_ = false;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::atomic<uint32_t> messages_{0};
};

/// Names, versions and limits of a device; without samples and tier.
DeviceInfo describe(const Device& device);

}  // namespace pelage::vulkan
