// Frames that do not run: the scene keeps what each frame changes on the host until it has run, and
// puts it back where it does not.
#include "scene/frame_journal.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <exception>
#include <new>
#include <utility>

#include "passes/list_ticket.h"

namespace pelage::detail {

namespace {

// Numbers of frames, over all scenes, so that no list is taken for one of another scene.
std::atomic<uint64_t> g_frames{0};

bool isDelivered(const FrameCheckpoint& frame) {
  return !frame.abandoned && frame.run != nullptr && stateOf(*frame.run) == RunState::kDelivered;
}

// \param boundary  another frame begins: what is not recorded by now is not going to be.
bool isLost(const FrameCheckpoint& frame, bool boundary) {
  if (frame.abandoned) return true;
  if (frame.run == nullptr) return boundary;
  const RunState state = stateOf(*frame.run);
  return state == RunState::kAbandoned || (boundary && state == RunState::kOpen);
}

}  // namespace

void sendAgain(HairInternals& hair) {
  hair.bonesChanged = true;
  forgetRooms(hair.rooms);
  if (hair.skeleton != nullptr) hair.skeleton->copyFor(hair.skinning).version = 0;
}

void sendAgain(SdfColliderInternals& collider) {
  collider.buildPending = true;
  collider.builtBones.clear();
  if (collider.skeleton != nullptr) collider.skeleton->copyFor(collider.def.skinning).version = 0;
}

FrameJournal::Recording::Recording(FrameJournal& journal, PassList& list)
    : journal_(journal), list_(list) {
  if (list.frame == 0) {
    journal.save();
    list.frame = journal.open_.back().number;
  }
  journal.store_.removed = &journal.open_.back().removed;
}

FrameJournal::Recording::~Recording() {
  journal_.store_.removed = nullptr;
  journal_.open_.back().lastVersion = journal_.store_.resources.version();
  if (kept_) return;
  list_.frame = 0;
  try {
    journal_.restore();
  } catch (const std::bad_alloc&) {
    // An exception that is on its way says so already.
    if (std::uncaught_exceptions() == 0) std::terminate();
  }
}

void FrameJournal::finish(PassList& list) {
  if (hasRun(list)) return;
  store_.hazards.resolve(list);
  list.table = store_.resources.id();
  if (const char* reason = noteRun(list); reason != nullptr)
    detail::abandon(*list.run->record, reason);
  if (list.frame == 0) return;
  const auto written = [&](const FrameCheckpoint& frame) { return frame.number == list.frame; };
  const auto frame = std::find_if(open_.begin(), open_.end(), written);
  // Its frame is over, or one that it was written on top of does not run.
  const bool lost =
      frame == open_.end() ||
      std::any_of(open_.begin(), frame, [](const auto& below) { return isLost(below, false); });
  if (lost)
    pelage::abandon(list.run);
  else
    frame->run = list.run->record;
}

void FrameJournal::abandon(const PassList& list) {
  const bool delivered = list.run != nullptr && stateOf(*list.run->record) == RunState::kDelivered;
  pelage::abandon(list.run);
  if (list.frame == 0) return;
  const auto found = std::find_if(open_.begin(), open_.end(),
                                  [&](const auto& frame) { return frame.number == list.frame; });
  if (found != open_.end())
    found->abandoned = true;
  else if (delivered)
    resetAll();
  settle(false);
}

void FrameJournal::settle(bool boundary) {
  if (boundary) {
    store_.hazards.abandonOpen();
    ++store_.frame;
  }
  if (boundary) commit();
  const auto lost = std::find_if(open_.begin(), open_.end(), [&](const FrameCheckpoint& frame) {
    return isLost(frame, boundary);
  });
  const auto kept = static_cast<size_t>(lost - open_.begin());
  while (open_.size() > kept) restore();
  collectShared();
}

void FrameJournal::save() {
  FrameCheckpoint frame;
  if (!spare_.empty()) {
    frame = std::move(spare_.back());
    spare_.pop_back();
  }
  frame.number = ++g_frames;
  frame.time = store_.time;
  frame.sdfKeys = store_.sdfs.keys;
  frame.sdfSurface = store_.sdfs.surface;
  frame.firstVersion = store_.resources.version();
  frame.removed.clear();
  frame.run = nullptr;
  frame.abandoned = false;
  // Element by element, into the memory of an earlier frame.
  size_t count = 0;
  const auto next = [&count](auto& all) -> auto& {
    if (count == all.size()) all.emplace_back();
    return all[count++];
  };
  for (HairObject& object : store_.hairs()) {
    HairCheckpoint& saved = next(frame.hairs);
    saved.object = &object;
    saved.state = static_cast<const HairFrameState&>(HairStore::of(object));
    saved.buffers = HairStore::buffersOf(object);
  }
  frame.hairs.resize(std::exchange(count, 0));
  for (SdfCollider& collider : store_.colliders()) {
    ColliderCheckpoint& saved = next(frame.colliders);
    saved.collider = &collider;
    saved.state = static_cast<const SdfFrameState&>(HairStore::of(collider));
    saved.buffers = HairStore::buffersOf(collider);
  }
  frame.colliders.resize(std::exchange(count, 0));
  for (SkeletonPose& skeleton : store_.skeletons()) {
    const SkeletonInternals& internals = HairStore::of(skeleton);
    next(frame.skeletons) = {&skeleton, internals.origin, internals.originKnown, internals.copies};
  }
  frame.skeletons.resize(count);
  open_.push_back(std::move(frame));
}

// Takes back the last frame.
void FrameJournal::restore() {
  FrameCheckpoint frame = std::move(open_.back());
  open_.pop_back();
  ++store_.moves;
  if (frame.run != nullptr) detail::abandon(*frame.run);
  for (HairCheckpoint& saved : frame.hairs) {
    HairInternals& now = HairStore::of(*saved.object);
    const bool reset = now.resetPending;
    std::swap(static_cast<HairFrameState&>(now), saved.state);
    // Resets that the application has asked for since stay.
    now.resetPending |= reset;
    // Bones on the GPU may have changed while their placement stayed.
    now.bonesChanged =
        now.bones != now.bonesBefore || (now.skeleton != nullptr && now.skeleton->isOnGpu());
    static_cast<HairOutputs&>(HairStore::buffersOf(*saved.object)) = saved.buffers;
  }
  for (ColliderCheckpoint& saved : frame.colliders) {
    SdfColliderInternals& now = HairStore::of(*saved.collider);
    const bool reset = now.resetPending, changed = now.verticesChanged;
    std::swap(static_cast<SdfFrameState&>(now), saved.state);
    now.resetPending |= reset;
    now.verticesChanged |= changed;
    static_cast<SdfOutputs&>(HairStore::buffersOf(*saved.collider)) = saved.buffers;
  }
  for (const SkeletonCheckpoint& saved : frame.skeletons) {
    SkeletonInternals& now = HairStore::of(*saved.skeleton);
    now.origin = saved.origin;
    now.originKnown = saved.originKnown;
    for (size_t i = 0; i < now.copies.size(); ++i) {
      if (now.copies[i].buffer == saved.copies[i].buffer)
        now.copies[i] = saved.copies[i];
      else
        now.copies[i].version = 0;
    }
  }
  store_.time = frame.time;
  store_.sdfs.keys = frame.sdfKeys;
  store_.sdfs.surface = frame.sdfSurface;
  for (uint32_t slot = 0; slot < store_.resources.end(); ++slot) {
    BufferId buffer = store_.resources.at(slot);
    const uint64_t version = store_.resources.versionOf(buffer);
    if (version > frame.firstVersion && version <= frame.lastVersion)
      store_.factory().remove(buffer);
  }
  spare_.push_back(std::move(frame));
}

void FrameJournal::takeBackAll() {
  while (!open_.empty()) restore();
}

bool FrameJournal::allHaveRun() const {
  return std::all_of(open_.begin(), open_.end(), isDelivered);
}

void FrameJournal::commit() {
  const auto first = std::find_if_not(open_.begin(), open_.end(), isDelivered);
  for (auto frame = open_.begin(); frame != first; ++frame) {
    for (RemovedBuffer& removed : frame->removed)
      if (store_.resources.find(removed.buffer) != nullptr) store_.factory().remove(removed.buffer);
    spare_.push_back(std::move(*frame));
  }
  open_.erase(open_.begin(), first);
}

void FrameJournal::forgetOwner(const void* owner) {
  for (FrameCheckpoint& frame : open_) {
    std::erase_if(frame.hairs, [&](const auto& saved) { return saved.object == owner; });
    std::erase_if(frame.colliders, [&](const auto& saved) { return saved.collider == owner; });
    std::erase_if(frame.skeletons, [&](const auto& saved) { return saved.skeleton == owner; });
    removeOf(frame, owner);
  }
}

// Removes at once what a frame has no use for of an owner.
void FrameJournal::removeOf(FrameCheckpoint& frame, const void* owner) {
  for (RemovedBuffer& removed : frame.removed) {
    if (removed.owner != owner) continue;
    if (store_.resources.find(removed.buffer) != nullptr)
      store_.factory().remove(removed.buffer);
    else
      removed.buffer = BufferId::kInvalid;
  }
  std::erase_if(frame.removed,
                [](const auto& removed) { return removed.buffer == BufferId::kInvalid; });
}

void FrameJournal::relayFrames() {
  if (store_.removed != nullptr) return;  // the frame makes them itself
  for (FrameCheckpoint& frame : open_) {
    removeOf(frame, nullptr);
    frame.sdfKeys = store_.sdfs.keys;
    frame.sdfSurface = store_.sdfs.surface;
    for (ColliderCheckpoint& saved : frame.colliders) {
      const SdfColliderInternals& now = HairStore::of(*saved.collider);
      saved.state.keyOffset = now.keyOffset;
      saved.state.keyCapacity = now.keyCapacity;
      saved.state.surfaceOffset = now.surfaceOffset;
      saved.state.buildPending = true;
    }
  }
}

void FrameJournal::resetAll(std::span<HairObject* const> kept) {
  takeBackAll();
  for (HairObject& object : store_.hairs()) {
    if (std::find(kept.begin(), kept.end(), &object) != kept.end()) continue;
    HairInternals& hair = HairStore::of(object);
    hair.resetPending = true;
    loseRooms(hair.rooms, HairStore::buffersOf(object), store_.factory());
  }
  for (SdfCollider& collider : store_.colliders()) HairStore::of(collider).resetPending = true;
  for (SkeletonPose& skeleton : store_.skeletons())
    for (auto& copy : HairStore::of(skeleton).copies) copy.version = 0;
}

// A table may be that of a frame which is taken back.
void FrameJournal::collectShared() {
  using Ids = std::array<BufferId, sizeof(HairOutputs) / sizeof(BufferId)>;
  const auto has = [](const HairOutputs& buffers, BufferId buffer) {
    const Ids ids = std::bit_cast<Ids>(buffers);
    return std::find(ids.begin(), ids.end(), buffer) != ids.end();
  };
  store_.shared.collect(store_.resources, store_.hazards, [&](BufferId buffer) {
    for (const HairObject& object : store_.hairs())
      if (has(object.buffers(), buffer)) return true;
    for (const FrameCheckpoint& frame : open_)
      for (const HairCheckpoint& saved : frame.hairs)
        if (has(saved.buffers, buffer)) return true;
    return false;
  });
}

}  // namespace pelage::detail
