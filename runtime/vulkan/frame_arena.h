// Host-visible memory of frames in flight: constants and staging. Slices are handed out from
// chunks; a chunk is used again when the last frame that took a slice of it has completed.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "buffer_memory.h"

namespace pelage::vulkan {

/// A piece of a chunk, to be written by the host before the command buffer is submitted.
struct ArenaSlice {
  VkBuffer buffer = VK_NULL_HANDLE;
  uint64_t generation = 0;  ///< names the chunk, never used twice
  VkDeviceSize offset = 0;
  std::byte* mapped = nullptr;
};

class FrameArena {
 public:
  /// `nextGeneration` counts buffers; `onDestroy` hears of each chunk that goes.
  FrameArena(BufferMemory& memory, VkBufferUsageFlags usage, MemoryKind kind, const char* name,
             VkDeviceSize chunkSize, uint64_t& nextGeneration,
             std::function<void(uint64_t)> onDestroy);
  ~FrameArena();
  FrameArena(const FrameArena&) = delete;
  FrameArena& operator=(const FrameArena&) = delete;

  /// Memory for a frame; frame numbers do not fall. `size` > 0, `alignment` a power of two.
  Result<ArenaSlice> allocate(uint64_t frame, VkDeviceSize size, VkDeviceSize alignment);
  /// Takes back what frames up to `completedFrame` used.
  void collect(uint64_t completedFrame);
  /// Size of all chunks.
  uint64_t bytes() const;

 private:
  struct Chunk {
    AllocatedBuffer buffer;
    VkDeviceSize size = 0;
    VkDeviceSize used = 0;
    uint64_t generation = 0;
    uint64_t frame = 0;  // the last that took a slice
  };

  BufferMemory& memory_;
  VkBufferUsageFlags usage_;
  MemoryKind kind_;
  const char* name_;
  VkDeviceSize chunkSize_;
  uint64_t& nextGeneration_;
  std::function<void(uint64_t)> onDestroy_;
  std::vector<std::unique_ptr<Chunk>> busy_;
  std::vector<std::unique_ptr<Chunk>> free_;
};

}  // namespace pelage::vulkan
