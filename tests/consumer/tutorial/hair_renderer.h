// Hair in an engine that has a Vulkan device, command buffers and render passes.
#pragma once

#include <pelage/scene.h>
#include <pelage/vulkan.h>

#include <optional>

class HairRenderer {
 public:
  pelage::Result<void> create(const pelage::vulkan::RuntimeDef& device);
  /// Call it outside of a render pass. `completed` is the last frame that the GPU has finished.
  pelage::Result<void> record(uint64_t number, uint64_t completed, float seconds,
                              const pelage::View& view, const pelage::vulkan::ViewTarget& target,
                              VkCommandBuffer commands);
  /// Call it once vkQueueSubmit() has succeeded; if it was not called, the frame is lost.
  void submitted() { runtime_->submitted(); }

  pelage::Scene scene;

 private:
  std::optional<pelage::vulkan::Runtime> runtime_;
};
