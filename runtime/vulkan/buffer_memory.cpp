#include "buffer_memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace pelage::vulkan {
namespace {

constexpr VkDeviceSize kBlockSize = VkDeviceSize{32} << 20;

VkDeviceSize alignUp(VkDeviceSize value, VkDeviceSize alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

}  // namespace

BufferMemory::BufferMemory(const Device& device, const BufferAllocator& allocator)
    : device_(device), allocator_(allocator) {}

BufferMemory::~BufferMemory() {
  for (const std::unique_ptr<Block>& block : blocks_) freeBlock(*block);
}

Result<AllocatedBuffer> BufferMemory::create(VkDeviceSize size, VkBufferUsageFlags usage,
                                             MemoryKind kind, const char* name) {
  auto info = tagged<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = size;
  info.usage = usage;
  info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
  if (device_.families.size() > 1) {
    info.sharingMode = VK_SHARING_MODE_CONCURRENT;
    info.queueFamilyIndexCount = static_cast<uint32_t>(device_.families.size());
    info.pQueueFamilyIndices = device_.families.data();
  }

  if (allocator_.create == nullptr) return createOwn(info, kind, name);

  AllocatedBuffer buffer;
  const VkResult result = allocator_.create(allocator_.user, info, kind, name, buffer);
  if (result != VK_SUCCESS) {
    return vulkanError(
        result, fmt::format("buffer '{}' of {} bytes: the engine's allocator failed", name, size));
  }
  if (buffer.buffer == VK_NULL_HANDLE ||
      (kind != MemoryKind::kDevice && buffer.mapped == nullptr)) {
    allocator_.destroy(allocator_.user, buffer);
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("buffer '{}': the engine's allocator gave no {}", name,
                             buffer.buffer == VK_NULL_HANDLE ? "buffer" : "mapped pointer")};
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_BUFFER, buffer.buffer, name);
  return buffer;
}

void BufferMemory::destroy(const AllocatedBuffer& buffer) {
  if (buffer.buffer == VK_NULL_HANDLE) return;
  if (allocator_.create != nullptr) {
    allocator_.destroy(allocator_.user, buffer);
    return;
  }
  device_.vk.DestroyBuffer(device_.handle, buffer.buffer, device_.callbacks);
  const std::unique_ptr<Allocation> allocation(static_cast<Allocation*>(buffer.allocation));
  release(*allocation);
}

Result<AllocatedBuffer> BufferMemory::createOwn(const VkBufferCreateInfo& info, MemoryKind kind,
                                                const char* name) {
  const Functions& vk = device_.vk;
  auto allocation = std::make_unique<Allocation>();
  AllocatedBuffer buffer;
  VkResult result = vk.CreateBuffer(device_.handle, &info, device_.callbacks, &buffer.buffer);
  if (result != VK_SUCCESS)
    return vulkanError(result, fmt::format("buffer '{}' of {} bytes", name, info.size));

  VkMemoryRequirements needs = {};
  vk.GetBufferMemoryRequirements(device_.handle, buffer.buffer, &needs);
  if (needs.size > device_.maxAllocation) {
    vk.DestroyBuffer(device_.handle, buffer.buffer, device_.callbacks);
    return Error{ErrorCode::kUnsupported,
                 fmt::format("buffer '{}' needs {} bytes; one allocation of this device holds at "
                             "most {} (maxMemoryAllocationSize)",
                             name, needs.size, device_.maxAllocation)};
  }

  result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  for (const uint32_t type : memoryTypes(needs.memoryTypeBits, kind)) {
    result = allocate(type, needs, *allocation);
    if (result == VK_SUCCESS) break;
  }
  if (result == VK_SUCCESS) {
    result = vk.BindBufferMemory(device_.handle, buffer.buffer, allocation->block->memory,
                                 allocation->offset);
    if (result != VK_SUCCESS) release(*allocation);
  }
  if (result != VK_SUCCESS) {
    vk.DestroyBuffer(device_.handle, buffer.buffer, device_.callbacks);
    return vulkanError(result, fmt::format("memory of buffer '{}', {} bytes", name, needs.size));
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_BUFFER, buffer.buffer, name);
  if (allocation->block->mapped != nullptr)
    buffer.mapped = allocation->block->mapped + allocation->offset;
  buffer.allocation = allocation.release();
  return buffer;
}

std::vector<uint32_t> BufferMemory::memoryTypes(uint32_t allowed, MemoryKind kind) const {
  constexpr VkMemoryPropertyFlags kHost =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryPropertyFlags required = 0;
  VkMemoryPropertyFlags wanted = 0;
  VkMemoryPropertyFlags unwanted = 0;
  switch (kind) {
    case MemoryKind::kDevice:
      wanted = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
      // The part of device memory that the host sees may be small: leave it to those who need it.
      unwanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
      break;
    case MemoryKind::kConstants:
      required = kHost;
      wanted = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
      unwanted = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
      break;
    case MemoryKind::kStaging:
      required = kHost;
      unwanted = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
      break;
    case MemoryKind::kReadback:
      required = kHost;
      wanted = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
      break;
  }
  // Types that only special allocations may use.
  constexpr VkMemoryPropertyFlags kSpecial =
      VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT | VK_MEMORY_PROPERTY_PROTECTED_BIT |
      VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD | VK_MEMORY_PROPERTY_DEVICE_UNCACHED_BIT_AMD;
  std::vector<uint32_t> types;
  const auto penalty = [&](uint32_t type) {
    const VkMemoryPropertyFlags flags = device_.memory.memoryTypes[type].propertyFlags;
    return ((flags & wanted) == wanted ? 0 : 2) + ((flags & unwanted) == 0 ? 0 : 1);
  };
  for (uint32_t type = 0; type < device_.memory.memoryTypeCount; ++type) {
    const VkMemoryPropertyFlags flags = device_.memory.memoryTypes[type].propertyFlags;
    if ((allowed >> type & 1u) == 0 || (flags & required) != required || (flags & kSpecial) != 0)
      continue;
    types.push_back(type);
  }
  std::stable_sort(types.begin(), types.end(),
                   [&](uint32_t a, uint32_t b) { return penalty(a) < penalty(b); });
  return types;
}

VkResult BufferMemory::allocate(uint32_t type, const VkMemoryRequirements& needs, Allocation& out) {
  const VkDeviceSize heap =
      device_.memory.memoryHeaps[device_.memory.memoryTypes[type].heapIndex].size;
  const VkDeviceSize blockSize = std::min(kBlockSize, std::max(needs.alignment, heap / 16));
  const bool dedicated = needs.size > blockSize / 2;

  const auto take = [&](Block& block) {
    for (auto range = block.free.begin(); range != block.free.end(); ++range) {
      const auto [begin, size] = *range;
      const VkDeviceSize offset = alignUp(begin, needs.alignment);
      if (offset + needs.size > begin + size) continue;
      // Nodes are made first: the maps must not be half changed when memory runs out.
      if (offset + needs.size < begin + size)
        block.free.emplace(offset + needs.size, begin + size - offset - needs.size);
      if (offset > begin) {
        range->second = offset - begin;
      } else {
        block.free.erase(range);
      }
      out = {&block, offset, needs.size};
      return true;
    }
    return false;
  };

  if (!dedicated) {
    for (const std::unique_ptr<Block>& block : blocks_) {
      if (block->type == type && !block->dedicated && take(*block)) return VK_SUCCESS;
    }
  }
  const VkResult result = addBlock(type, dedicated ? needs.size : blockSize, dedicated);
  if (result != VK_SUCCESS) return result;
  return take(*blocks_.back()) ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

VkResult BufferMemory::addBlock(uint32_t type, VkDeviceSize size, bool dedicated) {
  auto block = std::make_unique<Block>();
  block->type = type;
  block->size = size;
  block->dedicated = dedicated;
  block->free.emplace(0, size);
  blocks_.reserve(blocks_.size() + 1);

  auto info = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  info.allocationSize = size;
  info.memoryTypeIndex = type;
  VkResult result =
      device_.vk.AllocateMemory(device_.handle, &info, device_.callbacks, &block->memory);
  if (result != VK_SUCCESS) return result;
  const VkMemoryPropertyFlags flags = device_.memory.memoryTypes[type].propertyFlags;
  if ((flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0) {
    void* mapped = nullptr;
    result = device_.vk.MapMemory(device_.handle, block->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
    if (result != VK_SUCCESS) {
      freeBlock(*block);
      return result;
    }
    block->mapped = static_cast<std::byte*>(mapped);
  }
  blocks_.push_back(std::move(block));
  return VK_SUCCESS;
}

void BufferMemory::release(const Allocation& allocation) {
  Block& block = *allocation.block;
  VkDeviceSize offset = allocation.offset;
  VkDeviceSize size = allocation.size;
  const auto next = block.free.lower_bound(offset);
  if (next != block.free.end() && next->first == offset + size) {
    size += next->second;
    block.free.erase(next);
  }
  const auto after = block.free.lower_bound(offset);
  if (after != block.free.begin()) {
    const auto previous = std::prev(after);
    if (previous->first + previous->second == offset) {
      offset = previous->first;
      size += previous->second;
      block.free.erase(previous);
    }
  }
  block.free[offset] = size;

  // One empty block a type is kept, so that an object that comes and goes costs no allocation.
  const auto empty = [](const Block& b) {
    return b.free.size() == 1 && b.free.begin()->second == b.size;
  };
  if (!empty(block)) return;
  const bool another = std::any_of(blocks_.begin(), blocks_.end(), [&](const auto& other) {
    return other.get() != &block && other->type == block.type && !other->dedicated && empty(*other);
  });
  if (!block.dedicated && !another) return;
  freeBlock(block);
  blocks_.erase(std::find_if(blocks_.begin(), blocks_.end(),
                             [&](const auto& other) { return other.get() == &block; }));
}

void BufferMemory::freeBlock(Block& block) {
  // Freeing unmaps.
  device_.vk.FreeMemory(device_.handle, block.memory, device_.callbacks);
}

}  // namespace pelage::vulkan
