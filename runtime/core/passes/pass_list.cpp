#include "pelage/pass_list.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <utility>

#include "passes/list_run.h"
#include "passes/pass_levels.h"
#include "pelage/list_check.h"

namespace pelage {
namespace {

// Maximum number of thread groups on an axis that every device of the three APIs supports.
constexpr uint64_t kMaxGroups = 65535;
// The buffers that successively had one slot of a table.
constexpr uint32_t kMaxGenerations = 0xffffffffu / ResourceTable::kMaxBuffers;

}  // namespace

TextureId newTextureId() {
  static std::atomic<uint32_t> count{0};
  return static_cast<TextureId>(++count);
}

ResourceTable::Id::Id() {
  static std::atomic<uint64_t> count{0};
  value = ++count;
  owner = static_cast<uint32_t>(value);
}

// The moved-from table becomes a new one.
ResourceTable::Id::Id(Id&& other) noexcept : Id() { *this = std::move(other); }

ResourceTable::Id& ResourceTable::Id::operator=(const Id& other) {
  if (this != &other) *this = Id(other);
  return *this;
}

ResourceTable::Id& ResourceTable::Id::operator=(Id&& other) noexcept {
  std::swap(value, other.value);
  std::swap(owner, other.owner);
  return *this;
}

BufferId ResourceTable::idOf(uint32_t tableIndex, uint32_t generation) const {
  return static_cast<BufferId>(uint64_t{id_.owner} << 32 |
                               (generation * kMaxBuffers + tableIndex + 1));
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
  const uint32_t tableIndex = free_.back();
  free_.pop_back();
  Slot& slot = buffers_[tableIndex];
  slot.desc = std::move(desc);
  slot.live = true;
  slot.version = version_;
  return idOf(tableIndex, slot.generation);
}

void ResourceTable::setInitial(BufferId id, std::span<const std::byte> bytes) {
  PELAGE_ASSERT(find(id) != nullptr, "initial data of a buffer that is not there");
  if (find(id) == nullptr) return;
  BufferDesc& desc = buffers_[indexOf(id)].desc;
  PELAGE_ASSERT(bytes.size() == desc.size, "initial data has the buffer's size");
  desc.initial.assign(bytes.begin(), bytes.end());
}

void ResourceTable::remove(BufferId id) {
  PELAGE_ASSERT(find(id) != nullptr, "removing a buffer that is not there");
  if (find(id) == nullptr) return;
  Slot& slot = buffers_[indexOf(id)];
  slot = {.desc = {}, .live = false, .generation = slot.generation + 1};
  if (slot.generation < kMaxGenerations) free_.push_back(indexOf(id));
  ++version_;
}

const BufferDesc* ResourceTable::find(BufferId id) const {
  const uint32_t tableIndex = indexOf(id);
  if (tableIndex >= buffers_.size()) return nullptr;
  const Slot& slot = buffers_[tableIndex];
  return slot.live && idOf(tableIndex, slot.generation) == id ? &slot.desc : nullptr;
}

BufferRange ResourceTable::whole(BufferId id) const {
  const BufferDesc* desc = find(id);
  return desc != nullptr ? BufferRange{id, desc->size} : BufferRange{};
}

uint64_t ResourceTable::versionOf(BufferId id) const {
  return find(id) != nullptr ? buffers_[indexOf(id)].version : 0;
}

BufferId ResourceTable::at(uint32_t tableIndex) const {
  const Slot& slot = buffers_[tableIndex];
  return slot.live ? idOf(tableIndex, slot.generation) : BufferId::kInvalid;
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
  area = {};
  samples = 0;
  run.reset();
  hold.reset();
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
                "the layouts of one stage of a draw must be the first ones of the other stage");
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

PassBuilder& PassBuilder::vertices(BufferRange range) {
  pass_.vertices = range;
  return *this;
}

PassBuilder& PassBuilder::bind(std::string_view name, BufferId buffer, uint64_t size,
                               uint64_t offset) {
  if (buffer != BufferId::kInvalid)
    offers_.push_back({.name = std::string(name), .buffer = {buffer, size, offset}});
  return *this;
}

PassBuilder& PassBuilder::bind(std::string_view name, TextureId texture) {
  if (texture != TextureId::kInvalid)
    offers_.push_back({.name = std::string(name), .texture = texture});
  return *this;
}

PassBuilder& PassBuilder::offer(std::span<const NamedResource> resources) {
  offers_.insert(offers_.end(), resources.begin(), resources.end());
  return *this;
}

PassBuilder& PassBuilder::constants(std::string_view name, std::span<const std::byte> bytes) {
  offers_.push_back(NamedResource::constants(std::string(name), bytes));
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

namespace {

// Whether the bindings of one layout serve another: a kernel of pelage's that an engine compiled
// with its own functions has tables of its own, of the same names.
bool isSame(const LayoutTable& a, const LayoutTable& b) {
  return &a == &b || std::strcmp(a.name, b.name) == 0;
}

// The entry of `from` that has the resource of an entry of `to`; beyond the last one: none.
Result<size_t> entryIn(const LayoutTable& from, const LayoutTable& to, uint8_t entry) {
  if (&from == &to) return entry;
  const LayoutEntry& wanted = to.entries[entry];
  const auto found = std::find_if(
      from.entries.begin(), from.entries.end(),
      [&](const LayoutEntry& other) { return std::strcmp(other.name, wanted.name) == 0; });
  if (found != from.entries.end() &&
      (found->kind != wanted.kind || found->stride != wanted.stride)) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string(": resource '") + wanted.name + "' of layout '" + to.name +
                     "' has another kind or size than the bindings: compile the kernel with the "
                     "HLSL of this version of pelage"};
  }
  return static_cast<size_t>(found - from.entries.begin());
}

// Returns the resource that bindings of this very table have for an entry. It is not bound where
// others may have it.
BoundResource boundIn(std::span<const LayoutBindings> bindings, const LayoutTable& layout,
                      uint8_t entry) {
  for (const LayoutBindings& one : bindings)
    if (&one.layout() == &layout) return one.at(entry);
  return {};
}

}  // namespace

Result<void> PassBuilder::checkLayouts(std::span<const LayoutBindings> bindings) const {
  const auto layouts = pass_.layouts();
  for (size_t i = 0; i < bindings.size(); ++i) {
    const LayoutTable& layout = bindings[i].layout();
    const auto isOfLayout = [&](const LayoutBindings& b) { return &b.layout() == &layout; };
    const bool known = std::any_of(layouts.begin(), layouts.end(),
                                   [&](const LayoutTable* own) { return isSame(*own, layout); });
    const auto before = bindings.first(i);
    const bool twice = std::any_of(before.begin(), before.end(), isOfLayout);
    if (known && !twice) continue;
    return Error{ErrorCode::kInvalidArgument,
                 std::string("pass ") + pass_.name + (known ? " got" : " has no layout for") +
                     " the bindings of layout '" + layout.name + "'" + (known ? " twice" : "")};
  }
  return {};
}

Result<BoundResource> PassBuilder::find(const KernelVariant& variant, const VariantBinding& use,
                                        std::span<const LayoutBindings> bindings) const {
  const LayoutTable& layout = *variant.kernel->layouts[use.set];
  const LayoutEntry& entry = layout.entries[use.entry];
  auto typed = std::find_if(bindings.begin(), bindings.end(),
                            [&](const LayoutBindings& b) { return &b.layout() == &layout; });
  if (typed == bindings.end()) {
    typed = std::find_if(bindings.begin(), bindings.end(),
                         [&](const LayoutBindings& b) { return isSame(b.layout(), layout); });
  }
  if (typed != bindings.end()) {
    const Result<size_t> at = entryIn(typed->layout(), layout, use.entry);
    if (!at) return Error{at.error().code, "pass " + variantName(variant) + at.error().message};
    const auto count = typed->layout().entries.size();
    const BoundResource resource =
        *at < count ? typed->at(static_cast<uint8_t>(*at)) : BoundResource();
    if (resource.isBound()) return resource;
  }
  const auto offer = std::find_if(offers_.begin(), offers_.end(),
                                  [&](const NamedResource& o) { return o.name == entry.name; });
  if (offer == offers_.end()) {
    const std::string name = std::string("'") + entry.name + "'";
    return Error{ErrorCode::kInvalidArgument,
                 "pass " + variantName(variant) + " needs resource " + name +
                     (typed == bindings.end()
                          ? ", which nobody offered: give the " + std::string(layout.name) +
                                "Bindings to finish(), or bind() it"
                          : ", which the " + std::string(layout.name) + "Bindings leave empty")};
  }
  BoundResource resource(offer->buffer);
  resource.texture = offer->texture;
  resource.block = offer->block;
  return resource;
}

// Passes in a row often share a block; an equal one is not stored twice.
uint64_t PassBuilder::addBlock(std::span<const std::byte> block) {
  constexpr uint64_t kAlignment = PassList::kConstantAlignment;
  const uint64_t padded = (block.size() + kAlignment - 1) / kAlignment * kAlignment;
  HostArray<std::byte>& all = list_.constants;
  const bool same = all.size() >= padded &&
                    std::memcmp(all.data() + all.size() - padded, block.data(), block.size()) == 0;
  if (!same) {
    all.insert(all.end(), block.begin(), block.end());
    all.resize((all.size() + kAlignment - 1) / kAlignment * kAlignment);
  }
  return all.size() - padded;
}

Result<void> PassBuilder::addBindings(const KernelVariant& variant,
                                      std::span<const LayoutBindings> bindings) {
  const Kernel& kernel = *variant.kernel;
  for (const VariantBinding& use : variant.bindings) {
    const LayoutEntry& entry = kernel.layouts[use.set]->entries[use.entry];
    // A kernel has each of its bindings once.
    const auto first = &variant == pass_.pixel ? list_.bindings.begin() + pass_.firstBinding
                                               : list_.bindings.end();
    const auto known = std::find_if(first, list_.bindings.end(), [&](const PassBinding& b) {
      return b.set == use.set && b.entry == use.entry;
    });
    if (known != list_.bindings.end()) {  // the other stage of the draw also uses it
      known->access = known->access | use.access;
      known->stages |= stageBit(kernel.stage);
      continue;
    }
    BoundResource resource = boundIn(bindings, *kernel.layouts[use.set], use.entry);
    if (!resource.isBound()) {
      const Result<BoundResource> found = find(variant, use, bindings);
      if (!found) return found.error();
      resource = *found;
    }
    PassBinding& binding = list_.bindings.emplace_back();  // finish() drops it after an error
    binding.set = use.set;
    binding.entry = use.entry;
    binding.buffer = resource.range.buffer;
    binding.offset = resource.range.offset;
    binding.size = resource.range.size;
    binding.texture = resource.texture;
    binding.access = use.access;
    binding.stages = stageBit(kernel.stage);
    if (entry.kind == ResourceKind::kUniformBuffer) {
      const std::span<const std::byte> block = resource.block;
      if (block.size() < entry.stride) {
        return Error{ErrorCode::kInvalidArgument,
                     "pass " + variantName(variant) + ": uniform block '" + entry.name + "' has " +
                         std::to_string(entry.stride) + " bytes, got " +
                         std::to_string(block.size())};
      }
      binding.size = block.size();
      binding.offset = addBlock(block);
    }
  }
  return {};
}

Result<void> PassBuilder::finish(std::span<const LayoutBindings> bindings) {
  PELAGE_ASSERT(pass_.kernel != nullptr, "finish() without dispatch() or draw()");
  const auto drop = [&](Result<void> result) {
    list_.bindings.resize(pass_.firstBinding);
    list_.specValues.resize(pass_.firstSpecValue);
    return result;
  };
  pass_.firstBinding = static_cast<uint32_t>(list_.bindings.size());
  if (Result<void> checked = checkLayouts(bindings); !checked) return drop(checked);
  if (pass_.kind == PassKind::kDispatch) {
    for (int axis = 0; axis < 3; ++axis) {
      const uint64_t size = pass_.kernel->groupSize[axis];
      PELAGE_ASSERT(size > 0, "a compute kernel has a group size");
      const uint64_t groups = (threads_[axis] + size - 1) / size;
      if (groups == 0) return drop({});
      if (groups > kMaxGroups) {
        return drop(Error{ErrorCode::kInvalidArgument,
                          "pass " + variantName(*pass_.kernel) + " needs " +
                              std::to_string(groups) + " thread groups on axis " + "xyz"[axis] +
                              std::string(", the limit is 65535: split the object")});
      }
      pass_.groups[axis] = static_cast<uint32_t>(groups);
    }
  } else if (pass_.kind == PassKind::kDraw &&
             (pass_.elementCount == 0 || pass_.instanceCount == 0)) {
    return drop({});
  }
  if ((pass_.kernel->kernel->vertexInput != nullptr) !=
      (pass_.vertices.buffer != BufferId::kInvalid)) {
    return drop(Error{ErrorCode::kInvalidArgument,
                      "pass " + variantName(*pass_.kernel) +
                          (pass_.kernel->kernel->vertexInput != nullptr
                               ? " needs a buffer of vertices: give it to vertices()"
                               : " has no vertex inputs, but got vertices()")});
  }
  for (const KernelVariant* variant : {pass_.kernel, pass_.pixel}) {
    if (variant == nullptr) continue;
    if (Result<void> added = addBindings(*variant, bindings); !added) return drop(added);
  }
  pass_.bindingCount = static_cast<uint32_t>(list_.bindings.size()) - pass_.firstBinding;
  if (!isDraw(pass_.kind)) {
    // Dispatches come before draws, whatever the order of the calls.
    const auto firstDraw =
        std::partition_point(list_.passes.begin(), list_.passes.end(),
                             [](const Pass& pass) { return !isDraw(pass.kind); });
    list_.passes.insert(firstDraw, pass_);
  } else {
    list_.passes.push_back(pass_);
  }
  return {};
}

bool isLastOfLevel(const PassList& list, size_t dispatch) {
  const size_t next = dispatch + 1;
  return next == list.passes.size() || isDraw(list.passes[next].kind) ||
         list.passes[next].level != list.passes[dispatch].level;
}

// Returns true the first time since mark_ rose.
bool HazardTracker::begin(uint32_t tableIndex) {
  if (tableIndex >= states_.size()) {
    states_.resize(size_t{tableIndex} + 1);
    marks_.resize(states_.size());
  }
  return std::exchange(marks_[tableIndex], mark_) != mark_;
}

HazardTracker::State& HazardTracker::state(BufferId buffer) {
  const uint32_t tableIndex = ResourceTable::indexOf(buffer);
  const bool first = begin(tableIndex);
  State& state = states_[tableIndex];
  if (first) changes_.push_back({tableIndex, state});
  if (state.buffer != buffer) state = {.buffer = buffer};
  return state;
}

void HazardTracker::forget(BufferId buffer) {
  const uint32_t tableIndex = ResourceTable::indexOf(buffer);
  if (tableIndex < states_.size()) states_[tableIndex] = {};
}

// Merges the states with and without the changes from one on: the union of the accesses, and
// visible only if visible in both.
void HazardTracker::mergeFrom(size_t firstChange) {
  ++mark_;
  for (size_t i = firstChange; i < changes_.size(); ++i) {
    const auto& [tableIndex, old] = changes_[i];
    if (!begin(tableIndex)) continue;  // the first change has the state before all of them
    State& now = states_[tableIndex];
    if (old.buffer == BufferId::kInvalid || now.buffer != old.buffer) continue;
    now.readStages |= old.readStages;
    now.writeStages |= old.writeStages;
    now.uploadWrite |= old.uploadWrite;
    now.indexRead |= old.indexRead;
    now.vertexRead |= old.vertexRead;
    now.indirectRead |= old.indirectRead;
    now.visibleStages &= old.visibleStages;
    now.visibleIndex &= old.visibleIndex;
    now.visibleVertex &= old.visibleVertex;
    now.visibleIndirect &= old.visibleIndirect;
  }
}

// Releases lists that have run, and lists that never run.
void HazardTracker::settle() {
  using detail::RunState;
  const auto first = std::find_if(open_.begin(), open_.end(), [](const Open& open) {
    return detail::stateOf(*open.record) == RunState::kAbandoned;
  });
  if (first != open_.end()) {
    // Later lists were to run after it.
    for (auto open = open_.end(); open != first;) detail::abandon(*(--open)->record);
    mergeFrom(first->firstChange);
    changes_.resize(first->firstChange);
    open_.erase(first, open_.end());
  }
  std::erase_if(open_, [](const Open& open) {
    return detail::stateOf(*open.record) == RunState::kDelivered;
  });
  const size_t needed = open_.empty() ? changes_.size() : open_.front().firstChange;
  changes_.erase(changes_.begin(), changes_.begin() + static_cast<ptrdiff_t>(needed));
  for (Open& open : open_) open.firstChange -= needed;
}

void HazardTracker::abandonOpen() {
  for (auto open = open_.rbegin(); open != open_.rend(); ++open)
    if (detail::stateOf(*open->record) == detail::RunState::kOpen) detail::abandon(*open->record);
  settle();
}

void HazardTracker::forgetExecutor() {
  if (order_ == nullptr) return;
  const std::lock_guard lock(order_->mutex);
  order_->executor = ExecutorId::kUnknown;
}

namespace detail {

// The accesses of the passes of a level to one buffer, over all bindings.
struct BufferUse {
  BufferId buffer;
  StageMask readStages = 0;
  StageMask writeStages = 0;
  bool index = false;
  bool vertex = false;
  bool indirect = false;
};

// Memory that resolve() keeps from list to list.
struct ListSchedule {
  PassLevels levels;

  // Adds the accesses of a pass to those of its level.
  void add(const PassList& list, const Pass& pass) {
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      if (binding.buffer == BufferId::kInvalid) continue;
      BufferUse& use = useOf(binding.buffer);
      if (reads(binding.access)) use.readStages |= binding.stages;
      if (writes(binding.access)) use.writeStages |= binding.stages;
    }
    if (pass.indices != BufferId::kInvalid) useOf(pass.indices).index = true;
    if (pass.vertices.buffer != BufferId::kInvalid) useOf(pass.vertices.buffer).vertex = true;
    if (pass.indirect != BufferId::kInvalid) useOf(pass.indirect).indirect = true;
  }
  // The accesses of a level, in the order of its passes. The next level begins; they stay until it
  // does.
  std::span<const BufferUse> take() {
    ++level_;
    taken_.swap(uses_);
    uses_.clear();
    return taken_;
  }

 private:
  struct Place {
    uint64_t level = 0;  // that `use` is of
    size_t use = 0;      // index into uses_
  };
  BufferUse& useOf(BufferId buffer) {
    const uint32_t index = ResourceTable::indexOf(buffer);
    if (index >= places_.size()) places_.resize(size_t{index} + 1);
    Place& place = places_[index];
    if (place.level == level_) return uses_[place.use];
    place = {level_, uses_.size()};
    return uses_.emplace_back(BufferUse{.buffer = buffer});
  }
  uint64_t level_ = 1;
  HostArray<Place> places_;  // [table index]
  HostArray<BufferUse> uses_, taken_;
};

}  // namespace detail

namespace {

// State is HazardTracker's, which is private.

template <class State>
bool isWritten(const State& state) {
  return state.writeStages != 0 || state.uploadWrite;
}

template <class State>
bool isTouched(const State& state) {
  return isWritten(state) || state.readStages != 0 || state.indexRead || state.vertexRead ||
         state.indirectRead;
}

// A barrier between all that touched a buffer and what overwrites it.
template <class State>
Barrier barrierBehind(const State& state) {
  Barrier barrier{.buffer = state.buffer};
  if (isWritten(state)) barrier.before = barrier.before | Access::kWrite;
  if (state.readStages != 0) barrier.before = barrier.before | Access::kRead;
  barrier.beforeStages = state.writeStages | state.readStages;
  barrier.beforeUpload = state.uploadWrite;
  barrier.beforeIndex = state.indexRead;
  barrier.beforeVertex = state.vertexRead;
  barrier.beforeIndirect = state.indirectRead;
  return barrier;
}

template <class State>
void applyWrite(State& now, const detail::BufferUse& use, HostArray<Barrier>& out) {
  if (isTouched(now)) {
    Barrier barrier = barrierBehind(now);
    barrier.after = use.readStages != 0 ? Access::kReadWrite : Access::kWrite;
    barrier.afterStages = use.readStages | use.writeStages;
    barrier.afterIndex = use.index;
    barrier.afterVertex = use.vertex;
    barrier.afterIndirect = use.indirect;
    out.push_back(barrier);
  }
  now = {.buffer = use.buffer};
  now.writeStages = use.writeStages;
}

template <class State>
void applyRead(State& now, const detail::BufferUse& use, HostArray<Barrier>& out) {
  const auto missing = static_cast<StageMask>(use.readStages & ~now.visibleStages);
  const bool missingIndex = use.index && !now.visibleIndex;
  const bool missingVertex = use.vertex && !now.visibleVertex;
  const bool missingIndirect = use.indirect && !now.visibleIndirect;
  if (isWritten(now) && (missing != 0 || missingIndex || missingVertex || missingIndirect)) {
    Barrier barrier{.buffer = use.buffer};
    barrier.before = Access::kWrite;
    barrier.beforeStages = now.writeStages;
    barrier.beforeUpload = now.uploadWrite;
    barrier.after = missing != 0 ? Access::kRead : Access::kNone;
    barrier.afterStages = missing;
    barrier.afterIndex = missingIndex;
    barrier.afterVertex = missingVertex;
    barrier.afterIndirect = missingIndirect;
    out.push_back(barrier);
  }
  now.visibleStages |= use.readStages;
  now.visibleIndex |= use.index;
  now.visibleVertex |= use.vertex;
  now.visibleIndirect |= use.indirect;
  now.readStages |= use.readStages;
  now.indexRead |= use.index;
  now.vertexRead |= use.vertex;
  now.indirectRead |= use.indirect;
}

template <class State>
void apply(State& now, const detail::BufferUse& use, HostArray<Barrier>& out) {
  if (use.writeStages != 0)
    applyWrite(now, use, out);
  else
    applyRead(now, use, out);
}

}  // namespace

void HazardTracker::resolve(PassList& list) {
  if (detail::hasRun(list)) return;
  list.run.reset();
  settle();
  ++mark_;
  const size_t firstChange = changes_.size();
  list.barriers.clear();
  list.uploadBarriers.clear();
  list.drawBarriers.clear();

  for (const Upload& upload : list.uploads) {
    const uint32_t tableIndex = ResourceTable::indexOf(upload.buffer);
    const bool uploaded = tableIndex < marks_.size() && marks_[tableIndex] == mark_;
    if (uploaded && states_[tableIndex].buffer == upload.buffer) continue;
    State& now = state(upload.buffer);
    if (isTouched(now)) {
      Barrier barrier = barrierBehind(now);
      barrier.after = Access::kWrite;
      barrier.afterUpload = true;
      list.uploadBarriers.push_back(barrier);
    }
    now = {.buffer = upload.buffer};
    now.uploadWrite = true;
  }

  // Passes of a level are as one, whose barriers come before the first of them.
  if (schedule_ == nullptr) schedule_ = std::make_shared<detail::ListSchedule>();
  std::span<const uint32_t> ends;
  if (levels_) ends = schedule_->levels.sort(list);
  size_t next = 0;
  const auto isDispatch = [&] {
    return next < list.passes.size() && !isDraw(list.passes[next].kind);
  };
  for (size_t level = 0; isDispatch(); ++level) {
    Pass& first = list.passes[next];
    const size_t end = levels_ ? ends[level] : next + 1;
    const auto firstBarrier = static_cast<uint32_t>(list.barriers.size());
    for (; next < end; ++next) {
      schedule_->add(list, list.passes[next]);
      list.passes[next].level = static_cast<uint32_t>(level);
      list.passes[next].firstBarrier = firstBarrier;
      list.passes[next].barrierCount = 0;
    }
    for (const detail::BufferUse& use : schedule_->take())
      apply(state(use.buffer), use, list.barriers);
    first.barrierCount = static_cast<uint32_t>(list.barriers.size()) - firstBarrier;
  }

  // All draws run inside one render pass, which allows no barriers: they are a level, too.
  for (; next < list.passes.size(); ++next) schedule_->add(list, list.passes[next]);
  for (const detail::BufferUse& use : schedule_->take())
    apply(state(use.buffer), use, list.drawBarriers);

  if (order_ == nullptr) order_ = std::make_shared<detail::RunOrder>();
  list.run = detail::openRun(order_, open_.empty() ? nullptr : open_.back().record.get(), list);
  open_.push_back({list.run->record, firstChange});
}

}  // namespace pelage
