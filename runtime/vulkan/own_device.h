// Instance, device and queues that the headless device makes for itself; several may share them.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>

#include "device.h"
#include "pelage/headless.h"

namespace pelage::vulkan {

/// Measures the time in which at least one submission runs. Threads: any.
class BusyClock {
 public:
  void begin();
  void end();
  double seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  mutable std::mutex mutex_;
  uint32_t running_ = 0;
  Clock::time_point since_;
  Clock::duration total_ = {};
};

/// A queue; the lock is for vkQueueSubmit.
struct OwnQueue {
  VkQueue handle = VK_NULL_HANDLE;
  std::mutex mutex;
};

class OwnDevice {
 public:
  OwnDevice() = default;
  ~OwnDevice();
  OwnDevice(const OwnDevice&) = delete;
  OwnDevice& operator=(const OwnDevice&) = delete;

  /// Errors: no loader, driver, device or queue as the definition asks for; validation is missing.
  Result<void> open(const HeadlessDef& def);

  const Device& device() const { return device_; }
  /// Returns the queues in turn. Threads: any.
  OwnQueue& nextQueue() { return queues_[next_++ % queues_.size()]; }
  /// Waits until all queues are idle. Threads: any.
  void waitIdle();
  /// Shared by the runtimes of all devices.
  VkPipelineCache pipelineCache() const { return pipelineCache_; }
  BusyClock& busy() { return busy_; }
  bool debugUtils() const { return debugUtils_; }
  /// Warnings and errors of validation so far.
  uint32_t messageCount() const { return messages_.load(); }

 private:
  Result<void> createInstance(const HeadlessDef& def);
  Result<void> choosePhysicalDevice(const HeadlessDef& def);
  Result<void> createDevice(uint32_t queues);

  Device device_;
  bool debugUtils_ = false;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::deque<OwnQueue> queues_;
  std::atomic<uint32_t> next_{0};
  VkPipelineCache pipelineCache_ = VK_NULL_HANDLE;
  BusyClock busy_;
  std::atomic<uint32_t> messages_{0};
};

/// Names, versions and limits of a device; without samples and tier.
DeviceInfo describe(const Device& device);

}  // namespace pelage::vulkan
