#include "frame_arena.h"

#include <algorithm>
#include <bit>

namespace pelage::vulkan {
namespace {

/// Free chunks above this go back to the device: they served a load, not a frame.
constexpr VkDeviceSize kLargestKeptChunk = VkDeviceSize{8} << 20;

}  // namespace

FrameArena::FrameArena(BufferMemory& memory, VkBufferUsageFlags usage, MemoryKind kind,
                       const char* name, VkDeviceSize chunkSize, uint64_t& nextGeneration,
                       std::function<void(uint64_t)> onDestroy)
    : memory_(memory),
      usage_(usage),
      kind_(kind),
      name_(name),
      chunkSize_(chunkSize),
      nextGeneration_(nextGeneration),
      onDestroy_(std::move(onDestroy)) {}

FrameArena::~FrameArena() {
  for (const auto& chunk : busy_) memory_.destroy(chunk->buffer);
  for (const auto& chunk : free_) memory_.destroy(chunk->buffer);
}

Result<ArenaSlice> FrameArena::allocate(uint64_t frame, VkDeviceSize size, VkDeviceSize alignment) {
  const auto slice = [&](Chunk& chunk) {
    const VkDeviceSize offset = (chunk.used + alignment - 1) / alignment * alignment;
    chunk.used = offset + size;
    chunk.frame = frame;
    return ArenaSlice{chunk.buffer.buffer, chunk.generation, offset,
                      static_cast<std::byte*>(chunk.buffer.mapped) + offset};
  };

  if (!busy_.empty()) {
    Chunk& last = *busy_.back();
    const VkDeviceSize offset = (last.used + alignment - 1) / alignment * alignment;
    if (last.frame == frame && offset + size <= last.size) return slice(last);
  }
  busy_.reserve(busy_.size() + 1);
  free_.reserve(busy_.size() + free_.size() + 1);  // so that collect() cannot run out of memory
  const auto fit = std::find_if(free_.begin(), free_.end(),
                                [&](const auto& chunk) { return chunk->size >= size; });
  if (fit != free_.end()) {
    busy_.push_back(std::move(*fit));
    free_.erase(fit);
    busy_.back()->used = 0;
    return slice(*busy_.back());
  }
  auto chunk = std::make_unique<Chunk>();
  chunk->size = size <= kLargestKeptChunk ? std::max(chunkSize_, std::bit_ceil(size)) : size;
  Result<AllocatedBuffer> buffer = memory_.create(chunk->size, usage_, kind_, name_);
  if (!buffer) return buffer.error();
  chunk->buffer = *buffer;
  chunk->generation = nextGeneration_++;
  busy_.push_back(std::move(chunk));
  return slice(*busy_.back());
}

uint64_t FrameArena::bytes() const {
  uint64_t bytes = 0;
  for (const auto* chunks : {&busy_, &free_})
    for (const auto& chunk : *chunks) bytes += chunk->size;
  return bytes;
}

void FrameArena::collect(uint64_t completedFrame) {
  for (auto& chunk : busy_) {
    if (chunk->frame > completedFrame) continue;
    if (chunk->size > kLargestKeptChunk) {
      onDestroy_(chunk->generation);
      memory_.destroy(chunk->buffer);
      chunk.reset();
    } else {
      free_.push_back(std::move(chunk));
    }
  }
  std::erase(busy_, nullptr);
}

}  // namespace pelage::vulkan
