// The part of an engine in the tests of pelage/vulkan.h: it owns instance, device, queue and
// frames, with the validation layer and synchronisation validation on.
#pragma once

#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pelage/vulkan.h"
#include "support/required_devices.h"

namespace runtime_test {

template <class T>
T tagged(VkStructureType type) {
  T structure = {};
  structure.sType = type;
  return structure;
}

/// A buffer with memory of its own.
struct EngineBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;  ///< where the host sees it
};

/// A square image with memory of its own, to draw into and to copy from.
struct EngineImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageAspectFlags aspects = 0;
};

/// Extensions of the device that some tests need.
struct DeviceExtensions {
  std::vector<const char*> names;
  void* features = nullptr;  ///< a chain for VkDeviceCreateInfo::pNext
};

class Engine {
 public:
  /// nullptr and a reason when there is no device or no validation layer.
  /// \param features  of the device, as far as it has them
  /// \param validates  false: without the layer, which allocates in every call
  /// \param extensions  enabled if it has all of them: hasExtensions()
  static std::unique_ptr<Engine> create(std::string& reason,
                                        const VkPhysicalDeviceFeatures& features = {},
                                        bool validates = true,
                                        const DeviceExtensions& extensions = {});
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// How a runtime is to be made on it.
  pelage::vulkan::RuntimeDef runtimeDef() const;

  EngineBuffer createBuffer(VkDeviceSize size, VkBufferUsageFlags usage, bool hostVisible) const;
  void destroyBuffer(const EngineBuffer& buffer) const;
  EngineImage createImage(VkFormat format, VkImageAspectFlags aspects, uint32_t size) const;
  void destroyImage(const EngineImage& image) const;

  /// A command buffer with a fence; frames use them in turn.
  struct Frame {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
  };
  Frame createFrame() const { return createFrame(family_); }
  Frame createFrame(uint32_t queueFamily) const;
  void destroyFrame(const Frame& frame) const;
  /// Waits for the frame's last submission, then begins its command buffer anew.
  void begin(const Frame& frame) const;
  void submit(const Frame& frame) const;
  /// In place of submit(): none of it runs.
  void discard(const Frame& frame) const;
  void wait(const Frame& frame) const;
  /// Copies a range to the host and waits. \param frame  of the copy
  std::vector<std::byte> read(const pelage::vulkan::BufferRange& range, const Frame& frame) const;

  VkDevice device() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  const VkPhysicalDeviceFeatures& features() const { return features_; }
  const VkPhysicalDeviceProperties& properties() const { return properties_; }
  bool dynamicRendering() const { return dynamicRendering_; }
  bool hasExtensions() const { return hasExtensions_; }
  uint32_t family() const { return family_; }
  VkQueue queue() const { return queue_; }
  /// A family that only computes and its queue; family() and queue() on a device without.
  uint32_t computeFamily() const { return computeFamily_; }
  VkQueue computeQueue() const { return computeQueue_; }
  uint32_t messageCount() const { return messages_.load(); }

 private:
  Engine() = default;
  bool open(std::string& reason, bool validates, const DeviceExtensions& extensions);

  std::atomic<uint32_t> messages_{0};
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_ = {};
  VkPhysicalDeviceFeatures features_ = {};
  VkDevice device_ = VK_NULL_HANDLE;
  uint32_t family_ = 0;
  uint32_t computeFamily_ = 0;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkQueue computeQueue_ = VK_NULL_HANDLE;
  bool dynamicRendering_ = false;
  bool hasExtensions_ = false;
};

/// Base of tests with an engine: its frames in flight, and a runtime on its device.
class EngineRun {
 protected:
  static constexpr size_t kFramesInFlight = 3;

  /// In SetUp(): skips the test without a device.
  void open(const VkPhysicalDeviceFeatures& features = {}, bool validates = true,
            const DeviceExtensions& extensions = {}) {
    std::string reason;
    engine_ = Engine::create(reason, features, validates, extensions);
    if (engine_ == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << reason;
    for (Engine::Frame& frame : frames_) frame = engine_->createFrame();
    copies_ = engine_->createFrame();
  }
  void createRuntime(const pelage::vulkan::RuntimeDef& def) {
    pelage::Result<pelage::vulkan::Runtime> made = pelage::vulkan::Runtime::create(def);
    ASSERT_TRUE(made) << made.error().message;
    runtime_.emplace(*std::move(made));
  }
  /// In TearDown().
  void close() {
    if (engine_ == nullptr) return;
    for (const Engine::Frame& frame : frames_) engine_->destroyFrame(frame);
    engine_->destroyFrame(copies_);
    runtime_.reset();
    EXPECT_EQ(engine_->messageCount(), 0u) << "a validation message";
  }
  /// Begins the next frame on the slot that was used kFramesInFlight frames ago.
  const Engine::Frame& beginFrame() {
    ++frame_;
    const Engine::Frame& slot = frames_[frame_ % kFramesInFlight];
    engine_->begin(slot);
    runtime_->beginFrame(frame_, frame_ > kFramesInFlight ? frame_ - kFramesInFlight : 0);
    return slot;
  }
  void submit(const Engine::Frame& frame) {
    engine_->submit(frame);
    runtime_->submitted();
  }
  void waitForFrames() const {
    for (const Engine::Frame& frame : frames_) engine_->wait(frame);
  }
  std::vector<std::byte> read(pelage::BufferId id) const {
    return engine_->read(runtime_->buffer(id), copies_);
  }

  std::unique_ptr<Engine> engine_;
  std::array<Engine::Frame, kFramesInFlight> frames_;
  Engine::Frame copies_;
  std::optional<pelage::vulkan::Runtime> runtime_;
  uint64_t frame_ = 0;
};

}  // namespace runtime_test
