#include "pelage/pass_list.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>

#include "passes/list_run.h"

namespace pelage {
namespace {

// The largest number of thread groups on an axis that every device of our three APIs accepts.
constexpr uint64_t kMaxGroups = 65535;
// Buffers that have a place of a table one after the other.
constexpr uint32_t kMaxGenerations = 0xffffffffu / ResourceTable::kMaxBuffers;

BufferId idOf(uint32_t place, uint32_t generation) {
  return static_cast<BufferId>(generation * ResourceTable::kMaxBuffers + place + 1);
}

std::string describe(const KernelVariant& variant) {
  std::string text = variant.kernel->name;
  if (variant.key[0] != '\0') text.append(" [").append(variant.key).append("]");
  return text;
}

}  // namespace

ResourceTable::Id::Id() {
  static std::atomic<uint64_t> count{0};
  value = ++count;
}

// What was moved from is another table from now on.
ResourceTable::Id::Id(Id&& other) noexcept : Id() { std::swap(value, other.value); }

ResourceTable::Id& ResourceTable::Id::operator=(const Id& other) {
  if (this != &other) value = Id().value;
  return *this;
}

ResourceTable::Id& ResourceTable::Id::operator=(Id&& other) noexcept {
  std::swap(value, other.value);
  return *this;
}

BufferId ResourceTable::add(BufferDesc desc) {
  PELAGE_ASSERT(desc.size > 0, "a buffer needs a size");
  PELAGE_ASSERT(desc.size % 4 == 0, "a buffer's size is a multiple of 4");
  PELAGE_ASSERT(desc.initial.empty() || desc.initial.size() == desc.size,
                "initial data has the buffer's size");
  ++version_;
  if (free_.empty()) {
    PELAGE_ASSERT(buffers_.size() < kMaxBuffers, "a table has at most 2^20 buffers");
    free_.push_back(static_cast<uint32_t>(buffers_.size()));
    buffers_.emplace_back();
  }
  const uint32_t place = free_.back();
  free_.pop_back();
  Slot& slot = buffers_[place];
  slot.desc = std::move(desc);
  slot.live = true;
  slot.version = version_;
  return idOf(place, slot.generation);
}

void ResourceTable::remove(BufferId id) {
  PELAGE_ASSERT(find(id) != nullptr, "removing a buffer that is not there");
  if (find(id) == nullptr) return;
  Slot& slot = buffers_[placeOf(id)];
  slot = {.desc = {}, .live = false, .generation = slot.generation + 1};
  if (slot.generation < kMaxGenerations) free_.push_back(placeOf(id));
  ++version_;
}

const BufferDesc* ResourceTable::find(BufferId id) const {
  const uint32_t place = placeOf(id);
  if (place >= buffers_.size()) return nullptr;
  const Slot& slot = buffers_[place];
  return slot.live && idOf(place, slot.generation) == id ? &slot.desc : nullptr;
}

uint64_t ResourceTable::versionOf(BufferId id) const {
  return find(id) != nullptr ? buffers_[placeOf(id)].version : 0;
}

BufferId ResourceTable::at(uint32_t place) const {
  const Slot& slot = buffers_[place];
  return slot.live ? idOf(place, slot.generation) : BufferId::kInvalid;
}

uint64_t ResourceTable::totalBytes() const {
  uint64_t bytes = 0;
  for (const Slot& slot : buffers_)
    if (slot.live) bytes += slot.desc.size;
  return bytes;
}

uint32_t ResourceTable::count() const {
  return static_cast<uint32_t>(
      std::count_if(buffers_.begin(), buffers_.end(), [](const Slot& slot) { return slot.live; }));
}

void PassList::clear() {
  passes.clear();
  bindings.clear();
  specValues.clear();
  barriers.clear();
  uploadBarriers.clear();
  drawBarriers.clear();
  uploads.clear();
  uploadData.clear();
  constants.clear();
  frame = table = 0;
  run.reset();
}

void addUpload(PassList& list, BufferId buffer, std::span<const std::byte> bytes, uint64_t offset) {
  PELAGE_ASSERT(bytes.size() % 4 == 0 && offset % 4 == 0, "uploads are made of whole 32-bit words");
  if (bytes.empty()) return;
  list.uploads.push_back({buffer, offset, list.uploadData.size(), bytes.size()});
  list.uploadData.insert(list.uploadData.end(), bytes.begin(), bytes.end());
}

PassBuilder& PassBuilder::dispatch(const KernelVariant& variant, uint32_t threadsX,
                                   uint32_t threadsY, uint32_t threadsZ) {
  PELAGE_ASSERT(variant.kernel->stage == Stage::kCompute, "a dispatch takes a compute kernel");
  pass_ = {};
  pass_.name = variant.kernel->name;
  pass_.kind = PassKind::kDispatch;
  pass_.kernel = &variant;
  const uint32_t threads[3] = {threadsX, threadsY, threadsZ};
  std::copy(std::begin(threads), std::end(threads), std::begin(threads_));
  offers_.clear();
  pass_.firstSpecValue = static_cast<uint32_t>(list_.specValues.size());
  return *this;
}

PassBuilder& PassBuilder::dispatchIndirect(const KernelVariant& variant, BufferId arguments,
                                           uint64_t offset) {
  PELAGE_ASSERT(arguments != BufferId::kInvalid, "an indirect dispatch takes a buffer");
  dispatch(variant, 1);
  pass_.kind = PassKind::kDispatchIndirect;
  pass_.indirect = arguments;
  pass_.indirectOffset = offset;
  return *this;
}

PassBuilder& PassBuilder::draw(const KernelVariant& vertex, const KernelVariant& pixel,
                               const DrawState& state, uint32_t elementCount,
                               uint32_t instanceCount, BufferId indices) {
  PELAGE_ASSERT(vertex.kernel->stage == Stage::kVertex && pixel.kernel->stage == Stage::kPixel,
                "a draw takes a vertex kernel and a pixel kernel");
  PELAGE_ASSERT(layoutsFit(*vertex.kernel, *pixel.kernel),
                "of the two stages of a draw, one has the first layouts of the other");
  pass_ = {};
  pass_.name = pixel.kernel->name;
  pass_.kind = PassKind::kDraw;
  pass_.kernel = &vertex;
  pass_.pixel = &pixel;
  pass_.state = state;
  pass_.elementCount = elementCount;
  pass_.instanceCount = instanceCount;
  pass_.indices = indices;
  offers_.clear();
  pass_.firstSpecValue = static_cast<uint32_t>(list_.specValues.size());
  return *this;
}

PassBuilder& PassBuilder::drawIndirect(const KernelVariant& vertex, const KernelVariant& pixel,
                                       const DrawState& state, BufferId arguments,
                                       uint64_t offset) {
  PELAGE_ASSERT(arguments != BufferId::kInvalid, "an indirect draw takes a buffer");
  draw(vertex, pixel, state, 0, 0);
  pass_.kind = PassKind::kDrawIndirect;
  pass_.indirect = arguments;
  pass_.indirectOffset = offset;
  return *this;
}

PassBuilder& PassBuilder::bind(std::string_view name, BufferId buffer, uint64_t size,
                               uint64_t offset) {
  if (buffer != BufferId::kInvalid)
    offers_.push_back({std::string(name), buffer, offset, size, {}});
  return *this;
}

PassBuilder& PassBuilder::constants(std::string_view name, std::span<const std::byte> bytes) {
  Offer offer;
  offer.name = name;
  offer.size = bytes.size();
  offer.block.assign(bytes.begin(), bytes.end());
  offers_.push_back(std::move(offer));
  return *this;
}

PassBuilder& PassBuilder::spec(std::span<const SpecValue> values) {
  list_.specValues.insert(list_.specValues.end(), values.begin(), values.end());
  pass_.specValueCount += static_cast<uint32_t>(values.size());
  return *this;
}

PassBuilder& PassBuilder::bytes(uint64_t bytes) {
  pass_.bytes = bytes;
  return *this;
}

Result<void> PassBuilder::addBindings(const KernelVariant& variant) {
  const Kernel& kernel = *variant.kernel;
  for (const VariantBinding& use : variant.bindings) {
    const LayoutEntry& entry = kernel.layouts[use.set]->entries[use.entry];
    const auto known = std::find_if(
        list_.bindings.begin() + pass_.firstBinding, list_.bindings.end(),
        [&](const PassBinding& b) { return b.set == use.set && b.entry == use.entry; });
    if (known != list_.bindings.end()) {  // the other stage of the draw uses it too
      known->access = known->access | use.access;
      known->stages |= stageBit(kernel.stage);
      continue;
    }
    const auto offer = std::find_if(offers_.begin(), offers_.end(),
                                    [&](const Offer& o) { return o.name == entry.name; });
    if (offer == offers_.end()) {
      return Error{ErrorCode::kInvalidArgument, "pass " + describe(variant) + " needs resource '" +
                                                    entry.name +
                                                    "', which nobody offered: bind() it"};
    }
    PassBinding binding;
    binding.set = use.set;
    binding.entry = use.entry;
    binding.buffer = offer->buffer;
    binding.offset = offer->offset;
    binding.size = offer->size;
    binding.access = use.access;
    binding.stages = stageBit(kernel.stage);
    if (entry.kind == ResourceKind::kUniformBuffer) {
      if (offer->block.size() < entry.stride) {
        return Error{ErrorCode::kInvalidArgument,
                     "pass " + describe(variant) + ": uniform block '" + entry.name + "' has " +
                         std::to_string(entry.stride) + " bytes, got " +
                         std::to_string(offer->block.size())};
      }
      // Passes in a row often share a block; an equal one is not stored twice.
      const uint64_t padded = (offer->block.size() + PassList::kConstantAlignment - 1) /
                              PassList::kConstantAlignment * PassList::kConstantAlignment;
      std::vector<std::byte>& all = list_.constants;
      const bool same =
          all.size() >= padded && std::memcmp(all.data() + all.size() - padded, offer->block.data(),
                                              offer->block.size()) == 0;
      if (!same) {
        all.insert(all.end(), offer->block.begin(), offer->block.end());
        all.resize((all.size() + PassList::kConstantAlignment - 1) / PassList::kConstantAlignment *
                   PassList::kConstantAlignment);
      }
      binding.offset = all.size() - padded;
    }
    list_.bindings.push_back(binding);
  }
  return {};
}

Result<void> PassBuilder::finish() {
  PELAGE_ASSERT(pass_.kernel != nullptr, "finish() without dispatch() or draw()");
  const auto drop = [&](Result<void> result) {
    list_.bindings.resize(pass_.firstBinding);
    list_.specValues.resize(pass_.firstSpecValue);
    return result;
  };
  pass_.firstBinding = static_cast<uint32_t>(list_.bindings.size());
  if (pass_.kind == PassKind::kDispatch) {
    for (int axis = 0; axis < 3; ++axis) {
      const uint64_t size = pass_.kernel->groupSize[axis];
      PELAGE_ASSERT(size > 0, "a compute kernel has a group size");
      const uint64_t groups = (threads_[axis] + size - 1) / size;
      if (groups == 0) return drop({});
      if (groups > kMaxGroups) {
        return drop(Error{ErrorCode::kInvalidArgument,
                          "pass " + describe(*pass_.kernel) + " needs " + std::to_string(groups) +
                              " thread groups on axis " + "xyz"[axis] +
                              std::string(", the limit is 65535: split the object")});
      }
      pass_.groups[axis] = static_cast<uint32_t>(groups);
    }
  } else if (pass_.kind == PassKind::kDraw &&
             (pass_.elementCount == 0 || pass_.instanceCount == 0)) {
    return drop({});
  }
  for (const KernelVariant* variant : {pass_.kernel, pass_.pixel}) {
    if (variant == nullptr) continue;
    if (Result<void> added = addBindings(*variant); !added) return drop(added);
  }
  pass_.bindingCount = static_cast<uint32_t>(list_.bindings.size()) - pass_.firstBinding;
  if (!isDraw(pass_.kind)) {
    // Dispatches come before draws, whatever the order of the calls.
    const auto firstDraw = std::find_if(list_.passes.begin(), list_.passes.end(),
                                        [](const Pass& pass) { return isDraw(pass.kind); });
    list_.passes.insert(firstDraw, pass_);
  } else {
    list_.passes.push_back(pass_);
  }
  return {};
}

HazardTracker::State& HazardTracker::state(BufferId buffer) {
  const uint32_t place = ResourceTable::placeOf(buffer);
  if (place >= states_.size()) states_.resize(size_t{place} + 1);
  State& state = states_[place];
  if (state.buffer != buffer) state = {.buffer = buffer};
  return state;
}

void HazardTracker::forget(BufferId buffer) {
  const uint32_t place = ResourceTable::placeOf(buffer);
  if (place < states_.size()) states_[place] = {};
}

// As if what happened since had happened or not: the union of the accesses, and visible is only
// what is so either way.
void HazardTracker::mergeWith(const std::vector<State>& before) {
  for (size_t place = 0; place < before.size(); ++place) {
    const State& old = before[place];
    State& now = states_[place];
    if (old.buffer == BufferId::kInvalid || now.buffer != old.buffer) continue;
    now.readStages |= old.readStages;
    now.writeStages |= old.writeStages;
    now.uploadWrite |= old.uploadWrite;
    now.indexRead |= old.indexRead;
    now.indirectRead |= old.indirectRead;
    now.visibleStages &= old.visibleStages;
    now.visibleIndex &= old.visibleIndex;
    now.visibleIndirect &= old.visibleIndirect;
  }
}

// Lets go of lists that have run, and of those that do not.
void HazardTracker::settle() {
  using detail::RunState;
  const auto first = std::find_if(open_.begin(), open_.end(), [](const Open& open) {
    return detail::stateOf(*open.record) == RunState::kAbandoned;
  });
  if (first != open_.end()) {
    // What comes after it was to run behind it.
    for (auto open = open_.end(); open != first;) detail::abandon(*(--open)->record);
    mergeWith(first->before);
    open_.erase(first, open_.end());
  }
  std::erase_if(open_, [](const Open& open) {
    return detail::stateOf(*open.record) == RunState::kDelivered;
  });
}

void HazardTracker::abandonOpen() {
  for (auto open = open_.rbegin(); open != open_.rend(); ++open)
    if (detail::stateOf(*open->record) == detail::RunState::kOpen) detail::abandon(*open->record);
  settle();
}

void HazardTracker::resolve(PassList& list) {
  // One that was resolved before, and has not run.
  list.run.reset();
  settle();
  std::vector<State> statesBefore = states_;
  list.barriers.clear();
  list.uploadBarriers.clear();
  list.drawBarriers.clear();

  // What a pass does with one buffer, all bindings of it together.
  struct Use {
    BufferId buffer;
    StageMask readStages = 0;
    StageMask writeStages = 0;
    bool index = false;
    bool indirect = false;
  };

  const auto before = [](const State& state, Barrier& barrier) {
    if (state.writeStages != 0 || state.uploadWrite)
      barrier.before = barrier.before | Access::kWrite;
    if (state.readStages != 0) barrier.before = barrier.before | Access::kRead;
    barrier.beforeStages = state.writeStages | state.readStages;
    barrier.beforeUpload = state.uploadWrite;
    barrier.beforeIndex = state.indexRead;
    barrier.beforeIndirect = state.indirectRead;
  };

  const auto apply = [&](const Use& use, std::vector<Barrier>& out) {
    State& now = state(use.buffer);
    const bool written = now.writeStages != 0 || now.uploadWrite;
    const bool touched = written || now.readStages != 0 || now.indexRead || now.indirectRead;
    if (use.writeStages != 0) {
      if (touched) {
        Barrier barrier{.buffer = use.buffer};
        before(now, barrier);
        barrier.after = use.readStages != 0 ? Access::kReadWrite : Access::kWrite;
        barrier.afterStages = use.readStages | use.writeStages;
        barrier.afterIndex = use.index;
        barrier.afterIndirect = use.indirect;
        out.push_back(barrier);
      }
      now = {.buffer = use.buffer};
      now.writeStages = use.writeStages;
      return;
    }
    const StageMask missing = static_cast<StageMask>(use.readStages & ~now.visibleStages);
    const bool missingIndex = use.index && !now.visibleIndex;
    const bool missingIndirect = use.indirect && !now.visibleIndirect;
    if (written && (missing != 0 || missingIndex || missingIndirect)) {
      Barrier barrier{.buffer = use.buffer};
      barrier.before = Access::kWrite;
      barrier.beforeStages = now.writeStages;
      barrier.beforeUpload = now.uploadWrite;
      barrier.after = missing != 0 ? Access::kRead : Access::kNone;
      barrier.afterStages = missing;
      barrier.afterIndex = missingIndex;
      barrier.afterIndirect = missingIndirect;
      out.push_back(barrier);
    }
    now.visibleStages |= use.readStages;
    now.visibleIndex |= use.index;
    now.visibleIndirect |= use.indirect;
    now.readStages |= use.readStages;
    now.indexRead |= use.index;
    now.indirectRead |= use.indirect;
  };

  std::vector<BufferId> uploaded;
  for (const Upload& upload : list.uploads) {
    if (std::find(uploaded.begin(), uploaded.end(), upload.buffer) != uploaded.end()) continue;
    uploaded.push_back(upload.buffer);
    State& now = state(upload.buffer);
    if (now.writeStages != 0 || now.uploadWrite || now.readStages != 0 || now.indexRead ||
        now.indirectRead) {
      Barrier barrier{.buffer = upload.buffer};
      before(now, barrier);
      barrier.after = Access::kWrite;
      barrier.afterUpload = true;
      list.uploadBarriers.push_back(barrier);
    }
    now = {.buffer = upload.buffer};
    now.uploadWrite = true;
  }

  std::vector<Use> uses;
  const auto useOf = [&](BufferId buffer) -> Use& {
    for (Use& use : uses)
      if (use.buffer == buffer) return use;
    return uses.emplace_back(Use{.buffer = buffer});
  };
  const auto collect = [&](const Pass& pass) {
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      if (binding.buffer == BufferId::kInvalid) continue;
      Use& use = useOf(binding.buffer);
      if (reads(binding.access)) use.readStages |= binding.stages;
      if (writes(binding.access)) use.writeStages |= binding.stages;
    }
    if (pass.indices != BufferId::kInvalid) useOf(pass.indices).index = true;
    if (pass.indirect != BufferId::kInvalid) useOf(pass.indirect).indirect = true;
  };

  for (Pass& pass : list.passes) {
    if (isDraw(pass.kind)) continue;
    uses.clear();
    collect(pass);
    pass.firstBarrier = static_cast<uint32_t>(list.barriers.size());
    for (const Use& use : uses) apply(use, list.barriers);
    pass.barrierCount = static_cast<uint32_t>(list.barriers.size()) - pass.firstBarrier;
  }

  // All draws run inside one render pass, where no barrier can stand: theirs go in front of it,
  // as if they were a single pass.
  uses.clear();
  for (const Pass& pass : list.passes)
    if (isDraw(pass.kind)) collect(pass);
  for (const Use& use : uses) apply(use, list.drawBarriers);

  if (order_ == nullptr) order_ = std::make_shared<detail::RunOrder>();
  list.run = detail::openRun(order_, open_.empty() ? nullptr : open_.back().record.get(), list);
  open_.push_back({list.run->record, std::move(statesBefore)});
}

}  // namespace pelage
