// Descriptor set layouts made from layout tables, and descriptor sets cached by what they hold.
#pragma once

#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "device.h"
#include "pelage/layout.h"

namespace pelage::vulkan {

/// FNV-1a over 64-bit words; keys of the caches are short arrays of them.
struct WordsHash {
  size_t operator()(const std::vector<uint64_t>& words) const;
};

/// A buffer, texture or sampler in a descriptor set, for one entry of the layout.
struct BoundBuffer {
  uint32_t entry = 0;  ///< index into LayoutTable::entries
  /// Names the buffer or texture; handles may be used again, this is not.
  uint64_t generation = 0;
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize range = 0;
  VkDescriptorImageInfo image = {};  ///< of textures and samplers, which have no buffer
};

class Descriptors {
 public:
  explicit Descriptors(const Device& device) : device_(device) {}
  ~Descriptors();
  Descriptors(const Descriptors&) = delete;
  Descriptors& operator=(const Descriptors&) = delete;

  /// The layout of a table, made on the first call.
  Result<VkDescriptorSetLayout> layout(const LayoutTable& table);
  /// A layout without bindings, for sets that a group skips.
  Result<VkDescriptorSetLayout> emptyLayout();

  /// A set that holds exactly these buffers, ascending by entry. It is written once and never
  /// again while a frame that used it is in flight.
  Result<VkDescriptorSet> set(const LayoutTable& table, std::span<const BoundBuffer> buffers,
                              uint64_t frame);
  /// A buffer or texture is gone: sets that name it wait for their frames and are then used for
  /// others.
  void forgetBuffer(uint64_t generation);
  /// Reuses sets of completed frames: those of buffers that are gone, and those unused for long.
  void collect(uint64_t completedFrame);

 private:
  struct Layout {
    const LayoutTable* table = nullptr;
    VkDescriptorSetLayout handle = VK_NULL_HANDLE;
    std::vector<VkDescriptorPool> pools;
    uint32_t setsLeft = 0;  // in the last pool
    uint32_t poolSize = 0;  // sets of the last pool
    // By the entries that were written: lavapipe (Mesa 22.3) reads every entry of a bound set, also
    // those that no shader uses, and a set with fewer entries would keep buffers that are gone.
    std::unordered_map<uint64_t, std::vector<VkDescriptorSet>> free;
  };
  struct Cached {
    std::vector<VkDescriptorSet>* free = nullptr;  // where it goes when it is not used any more
    VkDescriptorSet set = VK_NULL_HANDLE;
    uint64_t lastFrame = 0;
  };

  Result<Layout*> find(const LayoutTable& table);
  Result<VkDescriptorSet> takeSet(Layout& layout, std::vector<VkDescriptorSet>& free);
  Result<VkDescriptorSetLayout> create(const LayoutTable* table);

  const Device& device_;
  VkDescriptorSetLayout empty_ = VK_NULL_HANDLE;
  std::unordered_map<const LayoutTable*, std::unique_ptr<Layout>> layouts_;
  // Key: layout, then (entry, generation, offset, range) of each buffer.
  std::unordered_map<std::vector<uint64_t>, Cached, WordsHash> sets_;
  std::vector<Cached> retired_;
  std::vector<uint64_t> key_;  // kept between calls: a lookup that hits allocates nothing
  uint64_t lastSweep_ = 0;
};

VkShaderStageFlags shaderStages(StageMask stages);
VkPipelineStageFlags pipelineStages(StageMask stages);
VkDescriptorType descriptorType(ResourceKind kind);

}  // namespace pelage::vulkan
