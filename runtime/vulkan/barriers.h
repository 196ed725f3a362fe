// Translates the barriers of a pass list. What to wait for was decided by the core.
#pragma once

#include <span>
#include <vector>

#include "device.h"
#include "pelage/pass_list.h"

namespace pelage::vulkan {

/// Where the buffer of a barrier lives.
struct BarrierTarget {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = 0;
};

/// Collects barriers and records them as one command.
class BarrierBatch {
 public:
  void add(const Barrier& barrier, const BarrierTarget& target);
  /// Records what was added, if anything, and starts over.
  void record(const Device& device, VkCommandBuffer commands);

 private:
  VkPipelineStageFlags before_ = 0;
  VkPipelineStageFlags after_ = 0;
  std::vector<VkBufferMemoryBarrier> barriers_;
};

}  // namespace pelage::vulkan
