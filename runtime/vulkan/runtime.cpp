// The Vulkan runtime: buffers of a resource table, and pass lists into command buffers.
//
// record() and recordDraws() work in two steps. The first resolves everything (pipelines, sets,
// memory) and finds every error; the second records and cannot fail. So a command buffer never
// holds half a list.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include "barriers.h"
#include "buffer_memory.h"
#include "descriptors.h"
#include "device.h"
#include "frame_arena.h"
#include "pelage/list_check.h"
#include "pelage/vulkan.h"
#include "pipelines.h"
#include "timers.h"

namespace pelage::vulkan {
namespace {

/// More descriptor sets than any group of layouts has; the device's own limit is checked as well.
constexpr size_t kMaxSets = 8;
constexpr VkDeviceSize kConstantsChunk = VkDeviceSize{64} << 10;
constexpr VkDeviceSize kStagingChunk = VkDeviceSize{256} << 10;
/// Enough for every copy of a buffer; uploads and constants are aligned to it.
constexpr VkDeviceSize kStagingAlignment = 16;

constexpr VkPipelineStageFlags kShaderStages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT |
                                               VK_PIPELINE_STAGE_VERTEX_SHADER_BIT |
                                               VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;

}  // namespace

// A buffer of the table on the device.
struct BufferSlot {
  bool live = false;
  BufferId id = BufferId::kInvalid;
  bool external = false;
  AllocatedBuffer own;
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = 0;
  uint64_t generation = 0;
  BufferUsage usage = BufferUsage::kStorage;
  std::string name;
  bool keepContents = false;
  // Its initial data: yet to be recorded; in a command buffer that has not been submitted.
  bool unfilled = false, filling = false;
};

struct PendingExternal {
  BufferId id = BufferId::kInvalid;
  ExternalBuffer buffer;
};

// A texture of the engine.
struct TextureSlot {
  ExternalTexture texture;
  uint64_t generation = 0;
};

struct RetiredBuffer {
  AllocatedBuffer buffer;
  uint64_t frame = 0;
  uint64_t size = 0;
};

// Constants of a list's passes from offset `first` of the list on.
struct CopiedConstants {
  ArenaSlice slice;
  uint64_t first = 0;

  uint32_t offsetOf(const PassBinding& binding) const {
    return static_cast<uint32_t>(slice.offset + binding.offset - first);
  }
};

// A pass, ready to be recorded.
struct ResolvedPass {
  Pipeline pipeline;
  struct Set {
    uint32_t index = 0;
    VkDescriptorSet handle = VK_NULL_HANDLE;
    uint32_t firstOffset = 0;
    uint32_t offsetCount = 0;
  };
  std::array<Set, kMaxSets> sets;
  uint32_t setCount = 0;
};

namespace {

// One labelled region of a command buffer, where labels are on.
class Label {
 public:
  Label(const Device& device, VkCommandBuffer commands, const char* text)
      : device_(device), commands_(commands) {
    if (device_.vk.CmdBeginDebugUtilsLabel == nullptr) return;
    auto label = tagged<VkDebugUtilsLabelEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
    label.pLabelName = text;
    device_.vk.CmdBeginDebugUtilsLabel(commands_, &label);
  }
  ~Label() {
    if (device_.vk.CmdEndDebugUtilsLabel != nullptr) device_.vk.CmdEndDebugUtilsLabel(commands_);
  }
  Label(const Label&) = delete;
  Label& operator=(const Label&) = delete;

 private:
  const Device& device_;
  VkCommandBuffer commands_;
};

uint32_t indexOf(BufferId id) { return ResourceTable::indexOf(id); }
Error invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

PixelArea areaOf(const VkRect2D& area) {
  return {static_cast<uint32_t>(area.offset.x), static_cast<uint32_t>(area.offset.y),
          area.extent.width, area.extent.height};
}

// Limits of a permutation. Sets have the resources of all permutations; Pipelines checks those.
TierLimits tierLimitsOf(const VkPhysicalDeviceLimits& limits, Tier maxTier) {
  TierLimits own = limitsOf(Tier::kWide);
  const uint32_t buffers = limits.maxPerStageDescriptorStorageBuffers;
  own.storageBuffers = {buffers, buffers, buffers};
  own.drawStorageBuffers = limits.maxDescriptorSetStorageBuffers;
  own.groupThreads = limits.maxComputeWorkGroupInvocations;
  std::copy(std::begin(limits.maxComputeWorkGroupSize), std::end(limits.maxComputeWorkGroupSize),
            std::begin(own.groupSize));
  own.groupSharedBytes = limits.maxComputeSharedMemorySize;
  return lowerOf(own, limitsOf(maxTier));
}

// The families of RuntimeDef; command buffers are of the first one.
Result<void> fillFamilies(const RuntimeDef& def, Device& device) {
  uint32_t count = 0;
  device.vk.GetPhysicalDeviceQueueFamilyProperties(device.physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> all(count);
  device.vk.GetPhysicalDeviceQueueFamilyProperties(device.physical, &count, all.data());
  const auto add = [&](uint32_t family, const char* field) -> Result<void> {
    if (family >= count) {
      return invalid(fmt::format("RuntimeDef::{} is {}, {} has {} families", field, family,
                                 device.properties.deviceName, count));
    }
    if ((all[family].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) {
      return Error{ErrorCode::kUnsupported,
                   fmt::format("RuntimeDef::{}: queue family {} of {} cannot compute: take one "
                               "with VK_QUEUE_COMPUTE_BIT",
                               field, family, device.properties.deviceName)};
    }
    if (std::ranges::find(device.families, family) != device.families.end()) return {};
    device.families.push_back(family);
    device.familyProperties.push_back(all[family]);
    return {};
  };
  if (Result<void> added = add(def.queueFamily, "queueFamily"); !added) return added;
  for (const uint32_t family : def.otherQueueFamilies)
    if (Result<void> added = add(family, "otherQueueFamilies"); !added) return added;
  device.queueFamily = def.queueFamily;
  device.queue = device.familyProperties.front();
  device.timestampBits = device.queue.timestampValidBits;
  for (const VkQueueFamilyProperties& family : device.familyProperties)
    device.timestampBits = std::min(device.timestampBits, family.timestampValidBits);
  return {};
}

Result<void> fillDevice(const RuntimeDef& def, Device& device) {
  if (def.instance == VK_NULL_HANDLE) return invalid("RuntimeDef::instance is null");
  if (def.physicalDevice == VK_NULL_HANDLE) return invalid("RuntimeDef::physicalDevice is null");
  if (def.device == VK_NULL_HANDLE) return invalid("RuntimeDef::device is null");
  if ((def.allocator.create == nullptr) != (def.allocator.destroy == nullptr))
    return invalid("RuntimeDef::allocator has only one of create and destroy");
  device.instance = def.instance;
  device.physical = def.physicalDevice;
  device.handle = def.device;
  device.callbacks = def.allocationCallbacks;
  device.features = def.enabledFeatures;

  if (Result<void> loaded = device.vk.loadGlobal(def.getInstanceProcAddr); !loaded) return loaded;
  if (Result<void> loaded = device.vk.loadInstance(def.instance); !loaded) return loaded;
  if (Result<void> loaded = device.vk.loadDevice(def.instance, def.device, def.debugUtils); !loaded)
    return loaded;

  const Functions& vk = device.vk;
  vk.GetPhysicalDeviceProperties(device.physical, &device.properties);
  device.tierLimits = tierLimitsOf(device.limits(), def.maxTier);
  const uint32_t version = device.properties.apiVersion;
  if (version < VK_API_VERSION_1_1) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{} has Vulkan {}.{}, the runtime needs 1.1: update its driver",
                             device.properties.deviceName, VK_API_VERSION_MAJOR(version),
                             VK_API_VERSION_MINOR(version))};
  }
  auto maintenance = tagged<VkPhysicalDeviceMaintenance3Properties>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES);
  device.subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  device.subgroup.pNext = &maintenance;
  auto properties =
      tagged<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties.pNext = &device.subgroup;
  vk.GetPhysicalDeviceProperties2(device.physical, &properties);
  device.subgroup.pNext = nullptr;
  device.maxAllocation = maintenance.maxMemoryAllocationSize;
  vk.GetPhysicalDeviceMemoryProperties(device.physical, &device.memory);

  return fillFamilies(def, device);
}

}  // namespace

struct Runtime::Impl {
  explicit Impl(const RuntimeDef& def)
      : allocator(def.allocator),
        memory(device, allocator),
        descriptors(device),
        pipelines(device, descriptors),
        timers(device),
        constantsArena(memory, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, MemoryKind::kConstants,
                       "pelage/constants", kConstantsChunk, nextGeneration,
                       [this](uint64_t generation) { descriptors.forgetBuffer(generation); }),
        stagingArena(memory, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::kStaging,
                     "pelage/staging", kStagingChunk, nextGeneration, [](uint64_t) {}) {}
  ~Impl() {
    for (const BufferSlot& slot : slots) memory.destroy(slot.own);
    for (const RetiredBuffer& retired : retiredBuffers) memory.destroy(retired.buffer);
    memory.destroy(filler);
    abandonFrame();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Buffers.
  const BufferSlot* find(BufferId id) const {
    const uint32_t index = indexOf(id);
    const bool known = index < slots.size() && slots[index].live && slots[index].id == id;
    return known ? &slots[index] : nullptr;
  }
  Result<void> update(const ResourceTable& resources, VkCommandBuffer commands);
  /// A buffer that update() makes.
  struct New {
    uint32_t index;
    const BufferDesc* desc;
    bool again;  ///< it is there, without its contents
    BufferSlot slot;
    ArenaSlice staging;
  };
  Result<void> create(const ResourceTable& resources, std::vector<New>& added);
  void fill(std::vector<New>& added, VkCommandBuffer commands);
  Result<void> checkExternal(const BufferDesc& desc, const ExternalBuffer& external) const;
  Result<BufferSlot> createSlot(const BufferDesc& desc, const ExternalBuffer* external);
  void retire(BufferSlot& slot);
  Result<void> enterFrame();
  void collect(uint64_t completed);
  void submitted();
  void abandonFrame();

  // Lists: the checking step.
  Result<void> check(const PassList& list, ListPart part) const;
  Result<void> checkTextures(const PassList& list, const Pass& pass) const;
  static PipelineRequest requestOf(const PassList& list, const Pass& pass,
                                   const TargetFormats* target) {
    return {pass.kernel, pass.pixel, list.specValuesOf(pass), pass.state,
            isDraw(pass.kind) ? target : nullptr};
  }
  Result<Pipeline> pipelineOf(const PassList& list, const Pass& pass, const TargetFormats* target);
  Result<void> makePipelines(const PassList& list, const TargetFormats* target);
  Result<void> resolve(const PassList& list, bool draws, const TargetFormats* target);
  Result<void> resolvePass(const PassList& list, const Pass& pass, const TargetFormats* target,
                           const CopiedConstants& constants, ResolvedPass& out);
  Result<ResolvedPass::Set> resolveSet(const Pass& pass, uint32_t set,
                                       std::span<const PassBinding> bindings,
                                       const CopiedConstants& constants);
  Result<CopiedConstants> copyConstants(const PassList& list, bool draws);
  Result<void> makeFiller();

  Result<void> checkGraphics() const;

  // Lists: the recording step.
  Result<void> record(const PassList& list, VkCommandBuffer commands);
  Result<size_t> reserveTimers(const PassList& list);
  void recordDispatches(const PassList& list, size_t span, VkCommandBuffer commands);
  Result<void> recordDraws(const PassList& list, VkCommandBuffer commands,
                           const TargetFormats& target, const VkRect2D& area);
  void recordUploads(const PassList& list, const ArenaSlice& data, VkCommandBuffer commands);
  void recordBarriers(std::span<const Barrier> list, VkCommandBuffer commands);
  void bind(const ResolvedPass& pass, VkPipelineBindPoint point, VkCommandBuffer commands) const;

  Device device;
  BufferAllocator allocator;
  BufferMemory memory;
  uint64_t nextGeneration = 1;
  Descriptors descriptors;
  Pipelines pipelines;
  Timers timers;
  FrameArena constantsArena;
  FrameArena stagingArena;

  uint64_t frame = 0;
  uint64_t completedFrame = 0;
  uint32_t maxFramesInFlight = 0;        // 0: any number
  std::vector<uint64_t> framesInFlight;  // that recorded something
  bool timestamps = false;

  std::vector<BufferSlot> slots;
  std::vector<PendingExternal> pendingExternals;
  std::vector<RetiredBuffer> retiredBuffers;
  std::unordered_map<TextureId, TextureSlot> textures;
  const ExecutorId executor = newExecutorId();
  uint64_t tableId = 0;  // 0: none was seen yet
  uint64_t tableVersion = 0;

  // Lists in this frame's command buffers, and whether these fill buffers, before submitted().
  std::vector<RunHandle> recordedRuns;
  bool fills = false;

  // Stands in for uniform blocks of a layout that a permutation does not use: a dynamic uniform
  // buffer must point somewhere when its set is bound.
  AllocatedBuffer filler;
  uint64_t fillerGeneration = 0;
  VkDeviceSize fillerSize = 0;

  // Timers of draws, reserved by record() for the recordDraws() of the same list.
  const PassList* timedList = nullptr;
  size_t timedDraws = 0;
  size_t timedDrawCount = 0;

  // Kept between calls, so that a frame like the last one allocates nothing.
  std::vector<ResolvedPass> resolved;
  std::vector<uint32_t> dynamicOffsets;
  std::vector<BoundBuffer> bound;
  std::vector<PixelArea> areas;
  BarrierBatch batch;
};

Result<void> Runtime::Impl::checkExternal(const BufferDesc& desc,
                                          const ExternalBuffer& external) const {
  VkMemoryRequirements needs = {};
  device.vk.GetBufferMemoryRequirements(device.handle, external.buffer, &needs);
  const VkDeviceSize rest = needs.size - std::min(needs.size, external.offset);
  const VkDeviceSize given = std::min(rest, external.size);
  if (given >= desc.size) return {};
  return invalid(fmt::format(
      "the engine's buffer for '{}' (registerBuffer()) has {} bytes at offset {}; it needs {}: "
      "give a larger one before the next update()",
      desc.name, given, external.offset, desc.size));
}

Result<BufferSlot> Runtime::Impl::createSlot(const BufferDesc& desc,
                                             const ExternalBuffer* external) {
  BufferSlot slot;
  slot.live = true;
  slot.size = desc.size;
  slot.usage = desc.usage;
  slot.name = desc.name;
  if (external != nullptr) {
    if (Result<void> fits = checkExternal(desc, *external); !fits) return fits.error();
    slot.external = true;
    slot.buffer = external->buffer;
    slot.offset = external->offset;
  } else {
    VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                               VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    if (contains(desc.usage, BufferUsage::kIndex)) usage |= VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    if (contains(desc.usage, BufferUsage::kVertex)) usage |= VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    if (contains(desc.usage, BufferUsage::kIndirect)) usage |= VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    Result<AllocatedBuffer> made =
        memory.create(desc.size, usage, MemoryKind::kDevice, desc.name.c_str());
    if (!made) return made.error();
    slot.own = *made;
    slot.buffer = made->buffer;
  }
  slot.generation = nextGeneration++;
  return slot;
}

void Runtime::Impl::retire(BufferSlot& slot) {
  descriptors.forgetBuffer(slot.generation);
  if (slot.own.buffer != VK_NULL_HANDLE) retiredBuffers.push_back({slot.own, frame, slot.size});
  slot = {};
}

// Collects new buffers in a list, so that an error can take all of them back.
Result<void> Runtime::Impl::create(const ResourceTable& resources, std::vector<New>& added) {
  const auto undo = [&](const Error& error) -> Result<void> {
    for (const New& item : added)
      if (!item.again) memory.destroy(item.slot.own);
    return error;
  };
  if (slots.size() < resources.end()) slots.resize(resources.end());
  retiredBuffers.reserve(retiredBuffers.size() + slots.size());
  for (uint32_t index = 0; index < resources.end(); ++index) {
    const BufferId id = resources.at(index);
    const BufferDesc* desc = resources.find(id);
    const bool there = slots[index].live && slots[index].id == id;
    if (desc == nullptr || (there && !slots[index].unfilled)) continue;
    added.reserve(added.size() + 1);
    if (there) {
      added.push_back({index, desc, true, slots[index], {}});
    } else {
      const auto external = std::find_if(pendingExternals.begin(), pendingExternals.end(),
                                         [&](const PendingExternal& p) { return p.id == id; });
      const bool given = external != pendingExternals.end();
      Result<BufferSlot> slot = createSlot(*desc, given ? &external->buffer : nullptr);
      if (!slot) return undo(slot.error());
      slot->id = id;
      slot->keepContents = given && external->buffer.keepContents;
      added.push_back({index, desc, false, *std::move(slot), {}});
    }
    if (desc->initial.empty() || added.back().slot.keepContents) continue;
    Result<ArenaSlice> staging =
        stagingArena.allocate(frame, desc->initial.size(), kStagingAlignment);
    if (!staging) return undo(staging.error());
    std::memcpy(staging->mapped, desc->initial.data(), desc->initial.size());
    added.back().staging = *staging;
  }
  return {};
}

// Takes what was created, and records its contents.
void Runtime::Impl::fill(std::vector<New>& added, VkCommandBuffer commands) {
  std::vector<VkBufferMemoryBarrier> barriers;
  barriers.reserve(added.size());
  for (New& item : added) {
    BufferSlot& slot = slots[item.index];
    slot = std::move(item.slot);
    std::erase_if(pendingExternals, [&](const PendingExternal& p) { return p.id == slot.id; });
    slot.unfilled = false;
    if (slot.keepContents) continue;
    slot.filling = fills = true;
    if (item.staging.buffer != VK_NULL_HANDLE) {
      const VkBufferCopy copy = {item.staging.offset, slot.offset, slot.size};
      device.vk.CmdCopyBuffer(commands, item.staging.buffer, slot.buffer, 1, &copy);
    } else {
      device.vk.CmdFillBuffer(commands, slot.buffer, slot.offset, slot.size, 0);
    }
    auto barrier = tagged<VkBufferMemoryBarrier>(VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                            VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                            VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT |
                            VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.buffer = slot.buffer;
    barrier.offset = slot.offset;
    barrier.size = slot.size;
    barriers.push_back(barrier);
  }
  if (!barriers.empty()) {
    // The list's hazards do not know of the initial data: whatever comes next waits for it here.
    const bool graphics = device.draws();
    const VkPipelineStageFlags next =
        (graphics ? kShaderStages | VK_PIPELINE_STAGE_VERTEX_INPUT_BIT
                  : VkPipelineStageFlags{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT}) |
        VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    if (!graphics) {
      for (VkBufferMemoryBarrier& barrier : barriers)
        barrier.dstAccessMask &=
            ~VkAccessFlags{VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT};
    }
    device.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, next, 0, 0, nullptr,
                                 static_cast<uint32_t>(barriers.size()), barriers.data(), 0,
                                 nullptr);
  }
}

Result<void> Runtime::Impl::update(const ResourceTable& resources, VkCommandBuffer commands) {
  PELAGE_ASSERT(frame > 0, "beginFrame() comes before update()");
  if (tableId != 0 && tableId != resources.id()) {
    return invalid(
        "update() got another ResourceTable than before; a runtime has the buffers of one: make a "
        "runtime for each scene");
  }
  if (tableId != 0 && tableVersion == resources.version()) return {};
  if (Result<void> entered = enterFrame(); !entered) return entered;

  std::vector<New> added;
  if (Result<void> created = create(resources, added); !created) return created;
  for (uint32_t index = 0; index < slots.size(); ++index) {
    if (slots[index].live && resources.find(slots[index].id) == nullptr) retire(slots[index]);
  }
  fill(added, commands);
  tableId = resources.id();
  tableVersion = resources.version();
  return {};
}

void Runtime::Impl::submitted() {
  for (const RunHandle& run : recordedRuns) setDelivered(run);
  recordedRuns.clear();
  if (!std::exchange(fills, false)) return;
  for (BufferSlot& slot : slots) slot.filling = false;
}

// Lists recorded since the last submitted() do not run.
void Runtime::Impl::abandonFrame() {
  for (auto run = recordedRuns.rbegin(); run != recordedRuns.rend(); ++run) abandon(*run);
  recordedRuns.clear();
  if (!std::exchange(fills, false)) return;
  for (BufferSlot& slot : slots) {
    slot.unfilled = slot.unfilled || slot.filling;
    slot.filling = false;
  }
  // So that update() looks at them.
  tableVersion = 0;
}

// Before anything of a frame is recorded, or memory taken for it.
Result<void> Runtime::Impl::enterFrame() {
  if (!framesInFlight.empty() && framesInFlight.back() == frame) return {};
  if (maxFramesInFlight != 0 && framesInFlight.size() >= maxFramesInFlight) {
    return invalid(fmt::format(
        "frame {} is refused: {} frames, from frame {} on, are not known to have completed; pass "
        "the last one whose fence was signalled to beginFrame() or collect(), or raise "
        "RuntimeDef::maxFramesInFlight",
        frame, framesInFlight.size(), framesInFlight.front()));
  }
  framesInFlight.push_back(frame);
  return {};
}

void Runtime::Impl::collect(uint64_t completed) {
  completedFrame = std::max(completedFrame, completed);
  std::erase_if(framesInFlight, [this](uint64_t open) { return open <= completedFrame; });
  std::erase_if(retiredBuffers, [&](const RetiredBuffer& retired) {
    if (retired.frame > completedFrame) return false;
    memory.destroy(retired.buffer);
    return true;
  });
  timers.collect(completedFrame);
  constantsArena.collect(completedFrame);
  stagingArena.collect(completedFrame);
  descriptors.collect(completedFrame);
}

Result<void> Runtime::Impl::check(const PassList& list, ListPart part) const {
  const VkPhysicalDeviceLimits& limits = device.limits();
  const DeviceLimits allowed = {
      .groups = {limits.maxComputeWorkGroupCount[0], limits.maxComputeWorkGroupCount[1],
                 limits.maxComputeWorkGroupCount[2]},
      .uniformBytes = limits.maxUniformBufferRange,
      .storageBytes = limits.maxStorageBufferRange,
      .storageAlignment = limits.minStorageBufferOffsetAlignment};
  const auto lookup = [this](BufferId id) -> std::optional<KnownBuffer> {
    const BufferSlot* slot = find(id);
    if (slot == nullptr) return {};
    return KnownBuffer{
        .name = slot->name, .size = slot->size, .usage = slot->usage, .offset = slot->offset};
  };
  if (Result<void> checked = checkList(list, lookup, allowed, part); !checked) return checked;
  for (const Pass& pass : list.passes) {
    if (part != ListPart::kAll && isDraw(pass.kind) != (part == ListPart::kDraws)) continue;
    if (Result<void> checked = checkTextures(list, pass); !checked) return checked;
  }
  return {};
}

Result<void> Runtime::Impl::checkTextures(const PassList& list, const Pass& pass) const {
  for (const PassBinding& binding : list.bindingsOf(pass)) {
    if (binding.texture == TextureId::kInvalid) continue;
    const LayoutEntry& entry = pass.layouts()[binding.set]->entries[binding.entry];
    const auto known = textures.find(binding.texture);
    const char* fault =
        known == textures.end() ? "the runtime does not know the texture: call registerTexture()"
        : entry.kind == ResourceKind::kSampler && known->second.texture.sampler == VK_NULL_HANDLE
            ? "the texture was registered without a sampler"
            : nullptr;
    if (fault == nullptr) continue;
    return invalid(fmt::format("pass {}, resource '{}': {}",
                               variantName(pass.pixel != nullptr ? *pass.pixel : *pass.kernel),
                               entry.name, fault));
  }
  return {};
}

// The first pass of a list without a pipeline makes those of all of the list's, at a time.
Result<Pipeline> Runtime::Impl::pipelineOf(const PassList& list, const Pass& pass,
                                           const TargetFormats* target) {
  if (const Pipeline* known = pipelines.find(requestOf(list, pass, target))) return *known;
  if (Result<void> made = makePipelines(list, target); !made) return made.error();
  return *pipelines.find(requestOf(list, pass, target));
}

Result<void> Runtime::Impl::makePipelines(const PassList& list, const TargetFormats* target) {
  std::vector<PipelineRequest> requests;
  for (const Pass& pass : list.passes) {
    if (!isDraw(pass.kind) || target != nullptr) requests.push_back(requestOf(list, pass, target));
  }
  return pipelines.make(requests);
}

Result<void> Runtime::Impl::makeFiller() {
  if (filler.buffer != VK_NULL_HANDLE) return {};
  const VkDeviceSize size =
      std::min<VkDeviceSize>(kConstantsChunk, device.limits().maxUniformBufferRange);
  Result<AllocatedBuffer> made = memory.create(size, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                               MemoryKind::kConstants, "pelage/unused constants");
  if (!made) return made.error();
  std::memset(made->mapped, 0, static_cast<size_t>(size));
  filler = *made;
  fillerSize = size;
  fillerGeneration = nextGeneration++;
  return {};
}

Result<CopiedConstants> Runtime::Impl::copyConstants(const PassList& list, bool draws) {
  uint64_t begin = UINT64_MAX;
  uint64_t end = 0;
  for (const Pass& pass : list.passes) {
    if (isDraw(pass.kind) != draws) continue;
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      const LayoutTable& table = *pass.layouts()[binding.set];
      if (table.entries[binding.entry].kind != ResourceKind::kUniformBuffer) continue;
      begin = std::min(begin, binding.offset);
      end = std::max(end, binding.offset + binding.size);
    }
  }
  if (begin >= end) return CopiedConstants{};
  Result<ArenaSlice> slice =
      constantsArena.allocate(frame, end - begin, PassList::kConstantAlignment);
  if (!slice) return slice.error();
  std::memcpy(slice->mapped, list.constants.data() + begin, static_cast<size_t>(end - begin));
  return CopiedConstants{*slice, begin};
}

Result<ResolvedPass::Set> Runtime::Impl::resolveSet(const Pass& pass, uint32_t set,
                                                    std::span<const PassBinding> bindings,
                                                    const CopiedConstants& constants) {
  const LayoutTable& table = *pass.layouts()[set];
  ResolvedPass::Set resolvedSet;
  resolvedSet.index = set;
  resolvedSet.firstOffset = static_cast<uint32_t>(dynamicOffsets.size());
  bound.clear();
  // Dynamic offsets go by ascending binding number, which entries need not follow.
  std::array<std::pair<uint32_t, uint32_t>, 32> offsets;
  size_t offsetCount = 0;
  for (uint32_t index = 0; index < table.entries.size(); ++index) {
    const LayoutEntry& entry = table.entries[index];
    const auto found = std::find_if(bindings.begin(), bindings.end(), [&](const auto& binding) {
      return binding.set == set && binding.entry == index;
    });
    if (entry.kind == ResourceKind::kUniformBuffer) {
      if (offsetCount == offsets.size()) {
        return Error{
            ErrorCode::kUnsupported,
            fmt::format("layout {} has more than {} uniform blocks", table.name, offsets.size())};
      }
      if (found != bindings.end()) {
        bound.push_back(
            {index, constants.slice.generation, constants.slice.buffer, 0, found->size, {}});
        offsets[offsetCount++] = {entry.binding, constants.offsetOf(*found)};
      } else {
        if (Result<void> made = makeFiller(); !made) return made.error();
        bound.push_back({index, fillerGeneration, filler.buffer, 0, fillerSize, {}});
        offsets[offsetCount++] = {entry.binding, 0};
      }
    } else if (found != bindings.end() && found->texture != TextureId::kInvalid) {
      const TextureSlot& slot = textures.at(found->texture);
      const ExternalTexture& texture = slot.texture;
      bound.push_back({.entry = index,
                       .generation = slot.generation,
                       .image = {texture.sampler, texture.view, texture.layout}});
    } else if (found != bindings.end()) {
      const BufferSlot& slot = *find(found->buffer);
      bound.push_back(
          {index, slot.generation, slot.buffer, slot.offset + found->offset, found->size, {}});
    }
  }
  std::sort(offsets.begin(), offsets.begin() + static_cast<std::ptrdiff_t>(offsetCount));
  for (size_t i = 0; i < offsetCount; ++i) dynamicOffsets.push_back(offsets[i].second);
  resolvedSet.offsetCount = static_cast<uint32_t>(offsetCount);
  Result<VkDescriptorSet> handle = descriptors.set(table, bound, frame);
  if (!handle) {
    return Error{handle.error().code,
                 fmt::format("pass {}: {}", variantName(*pass.kernel), handle.error().message)};
  }
  resolvedSet.handle = *handle;
  return resolvedSet;
}

Result<void> Runtime::Impl::resolvePass(const PassList& list, const Pass& pass,
                                        const TargetFormats* target,
                                        const CopiedConstants& constants, ResolvedPass& out) {
  Result<Pipeline> pipeline = pipelineOf(list, pass, target);
  if (!pipeline) return pipeline.error();
  out.pipeline = *pipeline;
  out.setCount = 0;

  const auto layouts = pass.layouts();
  if (layouts.size() > kMaxSets) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("kernel {} has {} descriptor sets, the runtime binds {}",
                             variantName(*pass.kernel), layouts.size(), kMaxSets)};
  }
  const auto bindings = list.bindingsOf(pass);
  for (uint32_t set = 0; set < layouts.size(); ++set) {
    const bool used = std::any_of(bindings.begin(), bindings.end(),
                                  [&](const PassBinding& binding) { return binding.set == set; });
    if (!used) continue;
    const Result<ResolvedPass::Set> ready = resolveSet(pass, set, bindings, constants);
    if (!ready) return ready.error();
    out.sets[out.setCount++] = *ready;
  }
  return {};
}

Result<void> Runtime::Impl::resolve(const PassList& list, bool draws, const TargetFormats* target) {
  PELAGE_ASSERT(frame > 0, "beginFrame() comes before record()");
  if (Result<void> entered = enterFrame(); !entered) return entered;
  resolved.clear();
  dynamicOffsets.clear();
  const ListPart part = draws ? ListPart::kDraws : ListPart::kDispatches;
  if (Result<void> checked = check(list, part); !checked) return checked;
  const Result<CopiedConstants> constants = copyConstants(list, draws);
  if (!constants) return constants.error();
  for (const Pass& pass : list.passes) {
    if (isDraw(pass.kind) != draws) continue;
    ResolvedPass& out = resolved.emplace_back();
    if (Result<void> done = resolvePass(list, pass, target, *constants, out); !done) return done;
  }
  return {};
}

void Runtime::Impl::recordUploads(const PassList& list, const ArenaSlice& data,
                                  VkCommandBuffer commands) {
  const auto overlaps = [](const Upload& a, const Upload& b) {
    return a.buffer == b.buffer && a.offset < b.offset + b.size && b.offset < a.offset + a.size;
  };
  size_t ordered = 0;  // uploads before this one are ordered against what follows
  for (size_t i = 0; i < list.uploads.size(); ++i) {
    const Upload& upload = list.uploads[i];
    // Uploads happen in order; copies do so only where something says so.
    const auto first = list.uploads.begin() + static_cast<std::ptrdiff_t>(ordered);
    const auto last = list.uploads.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::any_of(first, last, [&](const Upload& other) { return overlaps(upload, other); })) {
      auto barrier = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
      barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
      barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
      device.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                   VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0,
                                   nullptr);
      ordered = i;
    }
    const BufferSlot& slot = *find(upload.buffer);
    const VkBufferCopy copy = {data.offset + upload.dataOffset, slot.offset + upload.offset,
                               upload.size};
    device.vk.CmdCopyBuffer(commands, data.buffer, slot.buffer, 1, &copy);
  }
}

void Runtime::Impl::recordBarriers(std::span<const Barrier> list, VkCommandBuffer commands) {
  for (const Barrier& barrier : list) {
    const BufferSlot& slot = *find(barrier.buffer);
    batch.add(barrier, {slot.buffer, slot.offset, slot.size});
  }
  batch.record(device, commands);
}

void Runtime::Impl::bind(const ResolvedPass& pass, VkPipelineBindPoint point,
                         VkCommandBuffer commands) const {
  device.vk.CmdBindPipeline(commands, point, pass.pipeline.handle);
  for (uint32_t i = 0; i < pass.setCount; ++i) {
    const ResolvedPass::Set& set = pass.sets[i];
    device.vk.CmdBindDescriptorSets(commands, point, pass.pipeline.layout, set.index, 1,
                                    &set.handle, set.offsetCount,
                                    dynamicOffsets.data() + set.firstOffset);
  }
}

// Reserves the timers of a list, which may fail; returns those of its dispatches.
Result<size_t> Runtime::Impl::reserveTimers(const PassList& list) {
  timedList = nullptr;
  if (!timestamps || list.passes.empty()) return size_t{0};
  std::vector<Timers::TimedPass> dispatches, draws;
  for (const Pass& pass : list.passes) {
    if (isDraw(pass.kind))
      draws.push_back({pass.name, static_cast<uint32_t>(draws.size())});
    else
      dispatches.push_back({pass.name, pass.level});
  }
  timedDrawCount = draws.size();
  Result<size_t> reserved = timers.reserve(frame, std::move(dispatches));
  if (!reserved) return reserved.error();
  if (timedDrawCount > 0) {
    Result<size_t> drawSpan = timers.reserve(frame, std::move(draws));
    if (!drawSpan) return drawSpan.error();
    timedDraws = *drawSpan;
    timedList = &list;
  }
  return reserved;
}

void Runtime::Impl::recordDispatches(const PassList& list, size_t span, VkCommandBuffer commands) {
  const bool timed = timestamps && !list.passes.empty();
  uint32_t index = 0;
  if (timed) timers.write(span, 0, commands);
  for (const ResolvedPass& ready : resolved) {
    const Pass& pass = list.passes[index++];
    const Label label(device, commands, pass.name);
    recordBarriers(list.barriersOf(pass), commands);
    bind(ready, VK_PIPELINE_BIND_POINT_COMPUTE, commands);
    if (pass.kind == PassKind::kDispatchIndirect) {
      const BufferSlot& slot = *find(pass.indirect);
      device.vk.CmdDispatchIndirect(commands, slot.buffer, slot.offset + pass.indirectOffset);
    } else {
      device.vk.CmdDispatch(commands, pass.groups[0], pass.groups[1], pass.groups[2]);
    }
    if (timed && isLastOfLevel(list, index - 1)) timers.write(span, pass.level + 1, commands);
  }
}

Result<void> Runtime::Impl::record(const PassList& list, VkCommandBuffer commands) {
  if (Result<void> done = checkTable(list, tableId); !done) return done;
  if (Result<void> done = resolve(list, false, nullptr); !done) return done;
  if (Result<void> done = checkRun(list, executor); !done) return done;
  ArenaSlice data;
  if (!list.uploads.empty()) {
    Result<ArenaSlice> slice =
        stagingArena.allocate(frame, list.uploadData.size(), kStagingAlignment);
    if (!slice) return slice.error();
    data = *slice;
    std::memcpy(data.mapped, list.uploadData.data(), list.uploadData.size());
  }
  const Result<size_t> span = reserveTimers(list);
  if (!span) return span.error();

  // Nothing fails from here on.
  if (timestamps && !list.passes.empty()) timers.resetSpan(*span, commands);
  if (timedList != nullptr) timers.resetSpan(timedDraws, commands);
  if (!list.uploads.empty()) {
    const Label label(device, commands, "uploads");
    recordBarriers(list.uploadBarriers, commands);
    recordUploads(list, data, commands);
  }
  recordDispatches(list, *span, commands);
  recordBarriers(list.drawBarriers, commands);
  setRecorded(list.run, executor);
  if (list.run != nullptr) recordedRuns.push_back(list.run);
  return {};
}

Result<void> Runtime::Impl::checkGraphics() const {
  if (device.draws()) return {};
  return Error{ErrorCode::kUnsupported,
               fmt::format("queue family {} of {} cannot draw: take one with "
                           "VK_QUEUE_GRAPHICS_BIT",
                           device.queueFamily, device.properties.deviceName)};
}

Result<void> Runtime::Impl::recordDraws(const PassList& list, VkCommandBuffer commands,
                                        const TargetFormats& target, const VkRect2D& area) {
  if (Result<void> able = checkGraphics(); !able) return able;
  const VkPhysicalDeviceLimits& limits = device.limits();
  if (area.extent.width == 0 || area.extent.height == 0 ||
      area.extent.width > limits.maxViewportDimensions[0] ||
      area.extent.height > limits.maxViewportDimensions[1] || area.offset.x < 0 ||
      area.offset.y < 0) {
    return invalid(fmt::format("draws into an area of {} x {} pixels at ({}, {})",
                               area.extent.width, area.extent.height, area.offset.x,
                               area.offset.y));
  }
  if (Result<void> done = checkArea(list, areaOf(area)); !done) return done;
  if (Result<void> done = checkSamples(list, target.samples); !done) return done;
  if (Result<void> done = resolve(list, true, &target); !done) return done;
  if (resolved.empty()) return {};
  if (Result<void> done = checkDraws(list); !done) return done;

  const VkViewport viewport = {
      static_cast<float>(area.offset.x),
      static_cast<float>(area.offset.y) + static_cast<float>(area.extent.height),
      static_cast<float>(area.extent.width),
      -static_cast<float>(area.extent.height),
      0.0f,
      1.0f};
  device.vk.CmdSetViewport(commands, 0, 1, &viewport);
  device.vk.CmdSetScissor(commands, 0, 1, &area);
  const bool timed = timedList == &list && timedDrawCount == resolved.size();
  if (timed) timedList = nullptr;
  const size_t firstDraw = list.passes.size() - resolved.size();
  if (timed) timers.write(timedDraws, 0, commands);
  for (size_t i = 0; i < resolved.size(); ++i) {
    const Pass& pass = list.passes[firstDraw + i];
    const Label label(device, commands, pass.name);
    bind(resolved[i], VK_PIPELINE_BIND_POINT_GRAPHICS, commands);
    if (pass.vertices.buffer != BufferId::kInvalid) {
      const BufferSlot& slot = *find(pass.vertices.buffer);
      const VkDeviceSize offset = slot.offset + pass.vertices.offset;
      device.vk.CmdBindVertexBuffers(commands, 0, 1, &slot.buffer, &offset);
    }
    if (pass.kind == PassKind::kDrawIndirect) {
      const BufferSlot& slot = *find(pass.indirect);
      device.vk.CmdDrawIndirect(commands, slot.buffer, slot.offset + pass.indirectOffset, 1, 0);
    } else if (pass.indices != BufferId::kInvalid) {
      const BufferSlot& slot = *find(pass.indices);
      device.vk.CmdBindIndexBuffer(commands, slot.buffer, slot.offset, VK_INDEX_TYPE_UINT32);
      device.vk.CmdDrawIndexed(commands, pass.elementCount, pass.instanceCount, 0, 0, 0);
    } else {
      device.vk.CmdDraw(commands, pass.elementCount, pass.instanceCount, 0, 0);
    }
    if (timed) timers.write(timedDraws, static_cast<uint32_t>(i + 1), commands);
  }
  return {};
}

Runtime::Runtime(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Runtime::Runtime(Runtime&&) noexcept = default;
Runtime& Runtime::operator=(Runtime&&) noexcept = default;
Runtime::~Runtime() = default;

Result<Runtime> Runtime::create(const RuntimeDef& def) {
  return guarded([&]() -> Result<Runtime> {
    auto impl = std::make_unique<Impl>(def);
    if (Result<void> filled = fillDevice(def, impl->device); !filled) return filled.error();
    if (Result<void> opened = impl->pipelines.openCache(def.pipelineCache, def.pipelineCacheData);
        !opened)
      return opened.error();
    for (const KernelCodeList list : def.code) impl->pipelines.addCode(list);
    impl->pipelines.setThreads(def.pipelineThreads);
    impl->maxFramesInFlight = def.maxFramesInFlight;
    return Runtime(std::move(impl));
  });
}

void Runtime::addCode(KernelCodeList code) { impl_->pipelines.addCode(code); }

void Runtime::beginFrame(uint64_t frame, uint64_t completedFrame) {
  PELAGE_ASSERT(frame > impl_->frame, "frame numbers rise, from 1");
  PELAGE_ASSERT(completedFrame < frame, "a frame that begins has not completed");
  impl_->abandonFrame();
  impl_->collect(completedFrame);
  impl_->frame = frame;
  impl_->timedList = nullptr;
}

void Runtime::submitted() { impl_->submitted(); }

void Runtime::abandonFrame() { impl_->abandonFrame(); }

void Runtime::collect(uint64_t completedFrame) {
  PELAGE_ASSERT(completedFrame <= impl_->frame, "a frame that has not begun has not completed");
  impl_->collect(completedFrame);
  if (completedFrame == impl_->frame) impl_->timedList = nullptr;
}

void Runtime::registerBuffer(BufferId id, const ExternalBuffer& buffer) {
  PELAGE_ASSERT(buffer.buffer != VK_NULL_HANDLE, "an external buffer is a buffer");
  PELAGE_ASSERT(buffer.offset % 4 == 0, "the offset of an external buffer is a multiple of 4");
  PELAGE_ASSERT(impl_->find(id) == nullptr, "registerBuffer() comes before update()");
  if (buffer.buffer == VK_NULL_HANDLE) return;
  std::erase_if(impl_->pendingExternals,
                [&](const PendingExternal& pending) { return pending.id == id; });
  impl_->pendingExternals.push_back({id, buffer});
}

void Runtime::registerTexture(TextureId id, const ExternalTexture& texture) {
  PELAGE_ASSERT(id != TextureId::kInvalid, "a texture has an id of newTextureId()");
  const auto known = impl_->textures.find(id);
  if (known != impl_->textures.end()) {
    impl_->descriptors.forgetBuffer(known->second.generation);
    impl_->textures.erase(known);
  }
  if (texture.view == VK_NULL_HANDLE) return;
  impl_->textures.emplace(id, TextureSlot{texture, impl_->nextGeneration++});
}

Result<void> Runtime::update(const ResourceTable& resources, VkCommandBuffer commands) {
  return guarded([&] { return impl_->update(resources, commands); });
}

Result<void> Runtime::prepare(const PassList& list, const TargetFormats* target) {
  return guarded([&]() -> Result<void> {
    // Its buffers need not exist yet.
    if (Result<void> checked = checkPasses(list); !checked) return checked;
    return impl_->makePipelines(list, target);
  });
}

Tier Runtime::tier() const { return tierOf(impl_->device.tierLimits).value_or(Tier::kEs); }

Result<void> Runtime::supports(const PassList& list) const {
  return guarded([&]() -> Result<void> {
    if (Result<void> checked = checkPasses(list); !checked) return checked;
    for (const Pass& pass : list.passes) {
      if (isDraw(pass.kind)) {
        if (Result<void> able = impl_->checkGraphics(); !able) return able;
      }
      if (Result<void> able = impl_->pipelines.checkSupport(*pass.kernel, pass.pixel); !able)
        return able;
    }
    return {};
  });
}

Result<void> Runtime::supports(const TransparencySettings& settings,
                               const DrawnFeatures& hair) const {
  const Result<PassList> list = listToDraw(settings, hair, tier());
  if (!list) return list.error();
  return supports(*list);
}

std::vector<PipelineTime> Runtime::pipelineTimes() const { return impl_->pipelines.times(); }

Result<void> Runtime::record(const PassList& list, VkCommandBuffer commands) {
  return guarded([&] { return impl_->record(list, commands); });
}

Result<void> Runtime::useQueueFamily(uint32_t family) {
  Device& device = impl_->device;
  const auto found = std::ranges::find(device.families, family);
  if (found == device.families.end()) {
    return invalid(
        fmt::format("RuntimeDef names no queue family {}: add it to otherQueueFamilies", family));
  }
  device.queueFamily = family;
  device.queue = device.familyProperties[static_cast<size_t>(found - device.families.begin())];
  return {};
}

Result<void> Runtime::record(Frame& frame, VkCommandBuffer commands,
                             std::span<const ViewTarget> targets) {
  const ComputeCommands all = {commands, impl_->device.queueFamily};
  return recordFrame(frame, all, all, targets);
}

Result<void> Runtime::record(Frame& frame, const ComputeCommands& compute, VkCommandBuffer commands,
                             std::span<const ViewTarget> targets) {
  return recordFrame(frame, compute, {commands, impl_->device.families.front()}, targets);
}

Result<void> Runtime::recordFrame(Frame& frame, const ComputeCommands& before,
                                  const ComputeCommands& views,
                                  std::span<const ViewTarget> targets) {
  if (targets.size() != frame.viewCount()) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the frame has {} views, but there are {} targets", frame.viewCount(),
                             targets.size())};
  }
  if (Result<void> done = frame.finish(); !done) return done;
  impl_->areas.clear();
  for (const ViewTarget& target : targets) impl_->areas.push_back(areaOf(target.area));
  if (Result<void> fits = frame.checkAreas(impl_->areas); !fits) return fits;
  for (const FrameStep& step : frame.steps()) {
    if (step.view == FrameStep::kNoView) continue;
    const ViewTarget& target = targets[step.view];
    if (const char* missing = !target.begin ? "begin" : !target.end ? "end" : nullptr)
      return invalid(
          fmt::format("view {}: ViewTarget::{} is empty: give a function that {}s the render pass",
                      step.view, missing, missing));
    if (Result<void> fits = checkSamples(*step.list, target.formats.samples); !fits)
      return Error{fits.error().code, fmt::format("view {}: {}", step.view, fits.error().message)};
  }
  const uint32_t family = impl_->device.queueFamily;
  if (Result<void> used = useQueueFamily(before.queueFamily); !used) return used;
  bool drawing = false;
  // A function of one pointer needs no memory.
  const auto updateTable = [&](const ResourceTable& resources) {
    return update(resources, before.commands);
  };
  const auto recordStep = [&](const FrameStep& step) -> Result<void> {
    if (!drawing && step.view != FrameStep::kNoView) {
      drawing = true;
      if (Result<void> used = useQueueFamily(views.queueFamily); !used) return used;
    }
    return record(*step.list, drawing ? views.commands : before.commands);
  };
  const auto drawStep = [&](const FrameStep& step) {
    const ViewTarget& target = targets[step.view];
    target.begin(step);
    Result<void> drawn = recordDraws(*step.list, views.commands, target.formats, target.area);
    target.end(step);
    return drawn;
  };
  FrameExecutor executor;
  executor.update = std::cref(updateTable);
  executor.record = std::cref(recordStep);
  executor.draw = std::cref(drawStep);
  Result<void> done = frame.run(executor);
  if (Result<void> used = useQueueFamily(family); !used) return used;
  return done;
}

Result<void> Runtime::recordDraws(const PassList& list, VkCommandBuffer commands,
                                  const TargetFormats& target, const VkRect2D& area) {
  return guarded([&] { return impl_->recordDraws(list, commands, target, area); });
}

Result<VkDescriptorSetLayout> Runtime::createLayout(const LayoutTable& table) {
  return guarded([&] { return impl_->descriptors.layout(table); });
}

BufferRange Runtime::buffer(BufferId id) const {
  const BufferSlot* slot = impl_->find(id);
  return slot != nullptr ? BufferRange{slot->buffer, slot->offset, slot->size} : BufferRange{};
}

MemoryUse Runtime::memoryUse() const {
  return {bufferBytes(), impl_->constantsArena.bytes() + impl_->stagingArena.bytes(),
          static_cast<uint32_t>(impl_->framesInFlight.size())};
}

uint64_t Runtime::bufferBytes() const {
  uint64_t bytes = 0;
  for (const BufferSlot& slot : impl_->slots)
    if (slot.own.buffer != VK_NULL_HANDLE) bytes += slot.size;
  for (const RetiredBuffer& retired : impl_->retiredBuffers) bytes += retired.size;
  return bytes;
}

void Runtime::forget(VkRenderPass renderPass) { impl_->pipelines.forget(renderPass); }

void Runtime::setTimestamps(bool enabled) { impl_->timestamps = enabled; }

std::vector<PassTiming> Runtime::timings(uint64_t frame) const {
  return impl_->timers.results(frame);
}

Result<std::vector<std::byte>> Runtime::pipelineCacheData() const {
  return guarded([&] { return impl_->pipelines.cacheData(); });
}

}  // namespace pelage::vulkan
