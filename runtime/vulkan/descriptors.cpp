#include "descriptors.h"

#include <fmt/format.h>

#include <algorithm>

namespace pelage::vulkan {
namespace {

constexpr uint32_t kFirstPoolSets = 16;
constexpr uint32_t kMostPoolSets = 256;
/// A set that was not used in so many completed frames is given to others.
constexpr uint64_t kFramesKept = 128;
constexpr uint64_t kFramesBetweenSweeps = 32;
constexpr size_t kWordsPerBuffer = 3;

// The entry and the buffer in one word of a key; layouts have fewer than 256 entries.
uint64_t nameOf(uint64_t generation, uint32_t entry) { return generation << 8 | entry; }

}  // namespace

size_t WordsHash::operator()(const std::vector<uint64_t>& words) const {
  // In two halves, which do not wait for each other.
  uint64_t hashes[2] = {0xcbf29ce484222325u, 0x84222325cbf29ce4u};
  for (size_t i = 0; i < words.size(); ++i) {
    uint64_t& hash = hashes[i % 2];
    hash = (hash ^ words[i]) * 0x100000001b3u;
    hash ^= hash >> 29;  // words are longer than FNV's bytes: bring the high bits down
  }
  return static_cast<size_t>(hashes[0] ^ hashes[1] * 0x100000001b3u);
}

VkShaderStageFlags shaderStages(StageMask stages) {
  VkShaderStageFlags flags = 0;
  if ((stages & stageBit(Stage::kCompute)) != 0) flags |= VK_SHADER_STAGE_COMPUTE_BIT;
  if ((stages & stageBit(Stage::kVertex)) != 0) flags |= VK_SHADER_STAGE_VERTEX_BIT;
  if ((stages & stageBit(Stage::kPixel)) != 0) flags |= VK_SHADER_STAGE_FRAGMENT_BIT;
  return flags;
}

VkPipelineStageFlags pipelineStages(StageMask stages) {
  VkPipelineStageFlags flags = 0;
  if ((stages & stageBit(Stage::kCompute)) != 0) flags |= VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
  if ((stages & stageBit(Stage::kVertex)) != 0) flags |= VK_PIPELINE_STAGE_VERTEX_SHADER_BIT;
  if ((stages & stageBit(Stage::kPixel)) != 0) flags |= VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
  return flags;
}

VkDescriptorType descriptorType(ResourceKind kind) {
  switch (kind) {
    case ResourceKind::kUniformBuffer:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
    case ResourceKind::kStorageBuffer:
      return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    case ResourceKind::kSampledTexture:
      return VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    case ResourceKind::kStorageTexture:
      return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    case ResourceKind::kSampler:
      return VK_DESCRIPTOR_TYPE_SAMPLER;
  }
  PELAGE_ASSERT(false, "a resource kind that is not in the enumeration");
  return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

Descriptors::~Descriptors() {
  for (const auto& [table, layout] : layouts_) {
    for (VkDescriptorPool pool : layout->pools)
      device_.vk.DestroyDescriptorPool(device_.handle, pool, device_.callbacks);
    device_.vk.DestroyDescriptorSetLayout(device_.handle, layout->handle, device_.callbacks);
  }
  if (empty_ != VK_NULL_HANDLE)
    device_.vk.DestroyDescriptorSetLayout(device_.handle, empty_, device_.callbacks);
}

Result<VkDescriptorSetLayout> Descriptors::create(const LayoutTable* table) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  if (table != nullptr) {
    for (const LayoutEntry& entry : table->entries) {
      VkDescriptorSetLayoutBinding binding = {};
      binding.binding = entry.binding;
      binding.descriptorType = descriptorType(entry.kind);
      binding.descriptorCount = 1;
      binding.stageFlags = shaderStages(entry.stages);
      bindings.push_back(binding);
    }
  }
  auto info =
      tagged<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  info.bindingCount = static_cast<uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  const char* name = table != nullptr ? table->name : "empty";
  VkDescriptorSetLayout handle = VK_NULL_HANDLE;
  const VkResult result =
      device_.vk.CreateDescriptorSetLayout(device_.handle, &info, device_.callbacks, &handle);
  if (result != VK_SUCCESS) return vulkanError(result, fmt::format("layout {}", name));
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, handle, name);
  return handle;
}

Result<VkDescriptorSetLayout> Descriptors::emptyLayout() {
  if (empty_ == VK_NULL_HANDLE) {
    Result<VkDescriptorSetLayout> made = create(nullptr);
    if (!made) return made.error();
    empty_ = *made;
  }
  return empty_;
}

Result<Descriptors::Layout*> Descriptors::find(const LayoutTable& table) {
  std::unique_ptr<Layout>& layout = layouts_[&table];
  if (layout == nullptr) {
    auto made = std::make_unique<Layout>();
    made->table = &table;
    Result<VkDescriptorSetLayout> handle = create(&table);
    if (!handle) {
      layouts_.erase(&table);
      return handle.error();
    }
    made->handle = *handle;
    layout = std::move(made);
  }
  return layout.get();
}

Result<VkDescriptorSetLayout> Descriptors::layout(const LayoutTable& table) {
  Result<Layout*> found = find(table);
  if (!found) return found.error();
  return (*found)->handle;
}

Result<VkDescriptorSet> Descriptors::takeSet(Layout& layout, std::vector<VkDescriptorSet>& free) {
  if (!free.empty()) {
    VkDescriptorSet set = free.back();
    free.pop_back();
    return set;
  }
  if (layout.setsLeft == 0) {
    const uint32_t sets =
        layout.poolSize == 0 ? kFirstPoolSets : std::min(2 * layout.poolSize, kMostPoolSets);
    std::vector<VkDescriptorPoolSize> sizes;
    for (const LayoutEntry& entry : layout.table->entries) {
      const VkDescriptorType type = descriptorType(entry.kind);
      const auto known = std::find_if(sizes.begin(), sizes.end(),
                                      [&](const auto& size) { return size.type == type; });
      if (known != sizes.end()) {
        known->descriptorCount += sets;
      } else {
        sizes.push_back({type, sets});
      }
    }
    auto info = tagged<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
    info.maxSets = sets;
    info.poolSizeCount = static_cast<uint32_t>(sizes.size());
    info.pPoolSizes = sizes.data();
    layout.pools.reserve(layout.pools.size() + 1);
    VkDescriptorPool pool = VK_NULL_HANDLE;
    const VkResult result =
        device_.vk.CreateDescriptorPool(device_.handle, &info, device_.callbacks, &pool);
    if (result != VK_SUCCESS) {
      return vulkanError(result, fmt::format("descriptor pool of layout {}", layout.table->name));
    }
    layout.pools.push_back(pool);
    layout.poolSize = sets;
    layout.setsLeft = sets;
  }
  auto info = tagged<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  info.descriptorPool = layout.pools.back();
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout.handle;
  VkDescriptorSet set = VK_NULL_HANDLE;
  const VkResult result = device_.vk.AllocateDescriptorSets(device_.handle, &info, &set);
  if (result != VK_SUCCESS)
    return vulkanError(result, fmt::format("descriptor set of layout {}", layout.table->name));
  --layout.setsLeft;
  return set;
}

Result<VkDescriptorSet> Descriptors::set(const LayoutTable& table,
                                         std::span<const BoundBuffer> buffers, uint64_t frame) {
  key_.clear();
  key_.push_back(reinterpret_cast<uintptr_t>(&table));
  for (const BoundBuffer& bound : buffers) {
    key_.push_back(nameOf(bound.generation, bound.entry));
    key_.push_back(bound.offset);
    key_.push_back(bound.range);
  }
  if (const auto known = sets_.find(key_); known != sets_.end()) {
    known->second.lastFrame = frame;
    return known->second.set;
  }

  Result<Layout*> layout = find(table);
  if (!layout) return layout.error();
  // All host memory first: a set that was taken must not get lost.
  std::vector<VkDescriptorBufferInfo> infos(buffers.size());
  std::vector<VkWriteDescriptorSet> writes(buffers.size());
  uint64_t entries = 0;
  for (const BoundBuffer& bound : buffers) entries |= uint64_t{1} << (bound.entry % 64);
  std::vector<VkDescriptorSet>& free = (*layout)->free[entries];
  const auto [index, inserted] = sets_.emplace(key_, Cached{&free, VK_NULL_HANDLE, frame});
  free.reserve(sets_.size() + retired_.size());
  retired_.reserve(sets_.size() + retired_.size());
  Result<VkDescriptorSet> set = takeSet(**layout, free);
  if (!set) {
    sets_.erase(index);
    return set.error();
  }
  index->second.set = *set;

  for (size_t i = 0; i < buffers.size(); ++i) {
    const LayoutEntry& entry = table.entries[buffers[i].entry];
    infos[i] = {buffers[i].buffer, buffers[i].offset, buffers[i].range};
    writes[i] = tagged<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    writes[i].dstSet = *set;
    writes[i].dstBinding = entry.binding;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = descriptorType(entry.kind);
    writes[i].pBufferInfo = &infos[i];
    writes[i].pImageInfo = &buffers[i].image;
  }
  device_.vk.UpdateDescriptorSets(device_.handle, static_cast<uint32_t>(writes.size()),
                                  writes.data(), 0, nullptr);
  return *set;
}

void Descriptors::forgetBuffer(uint64_t generation) {
  std::erase_if(sets_, [&](const auto& entry) {
    const auto& [key, cached] = entry;
    for (size_t at = 1; at < key.size(); at += kWordsPerBuffer) {
      if (key[at] >> 8 == generation) {
        retired_.push_back(cached);
        return true;
      }
    }
    return false;
  });
}

void Descriptors::collect(uint64_t completedFrame) {
  std::erase_if(retired_, [&](const Cached& cached) {
    if (cached.lastFrame > completedFrame) return false;
    cached.free->push_back(cached.set);
    return true;
  });
  if (completedFrame < lastSweep_ + kFramesBetweenSweeps) return;
  lastSweep_ = completedFrame;
  std::erase_if(sets_, [&](const auto& entry) {
    const Cached& cached = entry.second;
    if (cached.lastFrame + kFramesKept > completedFrame) return false;
    cached.free->push_back(cached.set);
    return true;
  });
}

}  // namespace pelage::vulkan
