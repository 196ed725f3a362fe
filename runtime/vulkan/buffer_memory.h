// Buffers with memory: from the engine's allocator, or from blocks of our own.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "device.h"
#include "pelage/vulkan.h"

namespace pelage::vulkan {

/// Makes and destroys buffers. Few objects of the driver are used however many buffers there are:
/// the number of memory allocations of a device may be limited to 4096.
class BufferMemory {
 public:
  BufferMemory(const Device& device, const BufferAllocator& allocator);
  ~BufferMemory();
  BufferMemory(const BufferMemory&) = delete;
  BufferMemory& operator=(const BufferMemory&) = delete;

  /// `name` appears in errors and debuggers.
  Result<AllocatedBuffer> create(VkDeviceSize size, VkBufferUsageFlags usage, MemoryKind kind,
                                 const char* name);
  void destroy(const AllocatedBuffer& buffer);

 private:
  // One VkDeviceMemory. Offsets of free ranges map to their sizes; neighbours are merged.
  struct Block {
    uint32_t type = 0;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkDeviceSize size = 0;
    std::byte* mapped = nullptr;
    bool dedicated = false;
    std::map<VkDeviceSize, VkDeviceSize> free;
  };
  // AllocatedBuffer::allocation points to one if the memory is ours.
  struct Allocation {
    Block* block = nullptr;
    VkDeviceSize offset = 0;
    VkDeviceSize size = 0;
  };

  Result<AllocatedBuffer> createOwn(const VkBufferCreateInfo& info, MemoryKind kind,
                                    const char* name);
  /// Memory types that fit, the best first.
  std::vector<uint32_t> memoryTypes(uint32_t allowed, MemoryKind kind) const;
  VkResult allocate(uint32_t type, const VkMemoryRequirements& needs, Allocation& out);
  VkResult addBlock(uint32_t type, VkDeviceSize size, bool dedicated);
  void release(const Allocation& allocation);
  void freeBlock(Block& block);

  const Device& device_;
  BufferAllocator allocator_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace pelage::vulkan
