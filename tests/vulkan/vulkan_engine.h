// The part of an engine in the tests of pelage/vulkan.h: it owns instance, device, queue and
// frames, with the validation layer and synchronisation validation on.
#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "pelage/vulkan.h"

namespace runtime_test {

/// A buffer with memory of its own.
struct EngineBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;  ///< where the host sees it
};

class Engine {
 public:
  /// nullptr and a reason when there is no device or no validation layer.
  /// \param features  of the device, as far as it has them
  static std::unique_ptr<Engine> create(std::string& reason,
                                        const VkPhysicalDeviceFeatures& features = {});
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// How a runtime is to be made on it.
  pelage::vulkan::RuntimeDef runtimeDef() const;

  EngineBuffer createBuffer(VkDeviceSize size, VkBufferUsageFlags usage, bool hostVisible) const;
  void destroyBuffer(const EngineBuffer& buffer) const;

  /// A command buffer with a fence; frames use them in turn.
  struct Frame {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
  };
  Frame createFrame() const;
  void destroyFrame(const Frame& frame) const;
  /// Waits for the frame's last submission, then begins its command buffer anew.
  void begin(const Frame& frame) const;
  void submit(const Frame& frame) const;
  /// In place of submit(): none of it runs.
  void discard(const Frame& frame) const;
  void wait(const Frame& frame) const;

  VkDevice device() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  const VkPhysicalDeviceFeatures& features() const { return features_; }
  const VkPhysicalDeviceProperties& properties() const { return properties_; }
  bool dynamicRendering() const { return dynamicRendering_; }
  uint32_t messageCount() const { return messages_.load(); }

 private:
  Engine() = default;
  bool open(std::string& reason);

  std::atomic<uint32_t> messages_{0};
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_ = {};
  VkPhysicalDeviceFeatures features_ = {};
  VkDevice device_ = VK_NULL_HANDLE;
  uint32_t family_ = 0;
  VkQueue queue_ = VK_NULL_HANDLE;
  bool dynamicRendering_ = false;
};

}  // namespace runtime_test
