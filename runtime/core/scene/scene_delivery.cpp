// Frames that do not run: the scene keeps what each frame changes on the host until it has run, and
// puts it back where it does not.
#include "scene/scene_impl.h"

#include <algorithm>
#include <atomic>
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
  hair.sdfsBefore.clear();
  hair.givenPositions.forget();
  if (hair.skeleton != nullptr) hair.skeleton->copyFor(hair.skinning).version = 0;
}

void sendAgain(SdfColliderInternals& collider) {
  collider.buildPending = true;
  collider.builtBones.clear();
  if (collider.skeleton != nullptr) collider.skeleton->copyFor(collider.def.skinning).version = 0;
}

void SceneImpl::finish(PassList& list) {
  hazards_.resolve(list);
  list.table = resources_.id();
  if (const char* reason = noteRun(list); reason != nullptr)
    detail::abandon(*list.run->record, reason);
  if (list.frame == 0) return;
  const auto written = [&](const FrameCheckpoint& frame) { return frame.number == list.frame; };
  const bool open = std::any_of(frames_.open.begin(), frames_.open.end(), written);
  // Its frame is over, or one that it was written on top of does not run.
  bool lost = !open;
  for (auto frame = open ? frames_.open.begin() : HostArray<FrameCheckpoint>::iterator();
       open && !lost; ++frame) {
    if (written(*frame)) {
      frame->run = list.run->record;
      break;
    }
    lost = isLost(*frame, false);
  }
  if (lost) pelage::abandon(list.run);
}

void SceneImpl::abandon(const PassList& list) {
  const bool delivered = list.run != nullptr && stateOf(*list.run->record) == RunState::kDelivered;
  pelage::abandon(list.run);
  if (list.frame == 0) return;
  const auto found = std::find_if(frames_.open.begin(), frames_.open.end(),
                                  [&](const auto& frame) { return frame.number == list.frame; });
  if (found != frames_.open.end())
    found->abandoned = true;
  else if (delivered)
    sendEverything();
  settleFrames(false);
}

void SceneImpl::settleFrames(bool boundary) {
  if (boundary) {
    hazards_.abandonOpen();
    ++draws_.frame;
  }
  if (boundary) commitFrames();
  HostArray<FrameCheckpoint>& open = frames_.open;
  const auto lost = std::find_if(open.begin(), open.end(), [&](const FrameCheckpoint& frame) {
    return isLost(frame, boundary);
  });
  const auto kept = static_cast<size_t>(lost - open.begin());
  while (open.size() > kept) restoreFrame();
  collectShared();
}

void SceneImpl::saveFrame() {
  FrameCheckpoint frame;
  if (!frames_.spare.empty()) {
    frame = std::move(frames_.spare.back());
    frames_.spare.pop_back();
  }
  frame.number = ++g_frames;
  frame.time = time_;
  frame.sdfKeys = sdfs_.keys;
  frame.sdfSurface = sdfs_.surface;
  frame.firstVersion = resources_.version();
  frame.removed.clear();
  frame.run = nullptr;
  frame.abandoned = false;
  // Element by element, into the memory of an earlier frame.
  size_t count = 0;
  const auto next = [&count](auto& all) -> auto& {
    if (count == all.size()) all.emplace_back();
    return all[count++];
  };
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    HairCheckpoint& saved = next(frame.hairs);
    saved.object = object.get();
    saved.state = static_cast<const HairFrameState&>(*object->internals_);
    saved.buffers = object->buffers_;
  }
  frame.hairs.resize(std::exchange(count, 0));
  for (const auto& collider : sdfs_.colliders) {
    if (collider == nullptr) continue;
    ColliderCheckpoint& saved = next(frame.colliders);
    saved.collider = collider.get();
    saved.state = static_cast<const SdfFrameState&>(*collider->internals_);
    saved.buffers = collider->buffers_;
  }
  frame.colliders.resize(std::exchange(count, 0));
  for (const auto& skeleton : skeletons_) {
    if (skeleton == nullptr) continue;
    const SkeletonInternals& internals = *skeleton->internals_;
    next(frame.skeletons) = {skeleton.get(), internals.origin, internals.originKnown,
                             internals.copies};
  }
  frame.skeletons.resize(count);
  frames_.open.push_back(std::move(frame));
  frames_.recording = true;
}

// Takes back the last frame.
void SceneImpl::restoreFrame() {
  FrameCheckpoint frame = std::move(frames_.open.back());
  frames_.open.pop_back();
  if (frame.run != nullptr) detail::abandon(*frame.run);
  for (HairCheckpoint& saved : frame.hairs) {
    HairInternals& now = *saved.object->internals_;
    const bool reset = now.resetPending;
    std::swap(static_cast<HairFrameState&>(now), saved.state);
    // What the application has set since stays set.
    now.resetPending |= reset;
    // Bones on the GPU may have changed while their placement stayed.
    now.bonesChanged =
        now.bones != now.bonesBefore || (now.skeleton != nullptr && now.skeleton->isOnGpu());
    const BufferId forces = saved.object->buffers_.forces;
    saved.object->buffers_ = saved.buffers;
    saved.object->buffers_.forces = forces;
  }
  for (ColliderCheckpoint& saved : frame.colliders) {
    SdfColliderInternals& now = *saved.collider->internals_;
    const bool reset = now.resetPending, changed = now.verticesChanged;
    std::swap(static_cast<SdfFrameState&>(now), saved.state);
    now.resetPending |= reset;
    now.verticesChanged |= changed;
    const BufferId counts = saved.collider->buffers_.isoCounts;
    saved.collider->buffers_ = saved.buffers;
    saved.collider->buffers_.isoCounts = counts;
  }
  for (const SkeletonCheckpoint& saved : frame.skeletons) {
    SkeletonInternals& now = *saved.skeleton->internals_;
    now.origin = saved.origin;
    now.originKnown = saved.originKnown;
    for (size_t i = 0; i < now.copies.size(); ++i) {
      if (now.copies[i].buffer == saved.copies[i].buffer)
        now.copies[i] = saved.copies[i];
      else
        now.copies[i].version = 0;
    }
  }
  time_ = frame.time;
  sdfs_.keys = frame.sdfKeys;
  sdfs_.surface = frame.sdfSurface;
  for (uint32_t slot = 0; slot < resources_.end(); ++slot) {
    BufferId buffer = resources_.at(slot);
    const uint64_t version = resources_.versionOf(buffer);
    if (version > frame.firstVersion && version <= frame.lastVersion) room().remove(buffer);
  }
  frames_.spare.push_back(std::move(frame));
}

// Lets go of the frames that have run.
void SceneImpl::commitFrames() {
  HostArray<FrameCheckpoint>& open = frames_.open;
  const auto first = std::find_if_not(open.begin(), open.end(), isDelivered);
  for (auto frame = open.begin(); frame != first; ++frame) {
    for (RemovedBuffer& removed : frame->removed)
      if (resources_.find(removed.buffer) != nullptr) room().remove(removed.buffer);
    frames_.spare.push_back(std::move(*frame));
  }
  open.erase(open.begin(), first);
}

// Something goes, and with it what open frames know of it.
void SceneImpl::forgetOwner(const void* owner) {
  for (FrameCheckpoint& frame : frames_.open) {
    std::erase_if(frame.hairs, [&](const auto& saved) { return saved.object == owner; });
    std::erase_if(frame.colliders, [&](const auto& saved) { return saved.collider == owner; });
    std::erase_if(frame.skeletons, [&](const auto& saved) { return saved.skeleton == owner; });
    removeOf(frame, owner);
  }
}

// What a frame has no use for any more of an owner goes now.
void SceneImpl::removeOf(FrameCheckpoint& frame, const void* owner) {
  for (RemovedBuffer& removed : frame.removed) {
    if (removed.owner != owner) continue;
    if (resources_.find(removed.buffer) != nullptr)
      room().remove(removed.buffer);
    else
      removed.buffer = BufferId::kInvalid;
  }
  std::erase_if(frame.removed,
                [](const auto& removed) { return removed.buffer == BufferId::kInvalid; });
}

// The fields have new places between two frames: open frames are to be taken back to these.
void SceneImpl::relayFrames() {
  if (frames_.recording) return;
  for (FrameCheckpoint& frame : frames_.open) {
    removeOf(frame, nullptr);
    frame.sdfKeys = sdfs_.keys;
    frame.sdfSurface = sdfs_.surface;
    for (ColliderCheckpoint& saved : frame.colliders) {
      const SdfColliderInternals& now = *saved.collider->internals_;
      saved.state.keyOffset = now.keyOffset;
      saved.state.keyCapacity = now.keyCapacity;
      saved.state.surfaceOffset = now.surfaceOffset;
      saved.state.buildPending = true;
    }
  }
}

// Nothing is known of what the GPU has.
void SceneImpl::sendEverything(std::span<HairObject* const> kept) {
  while (!frames_.open.empty()) restoreFrame();
  for (const auto& object : objects_) {
    if (object == nullptr || std::find(kept.begin(), kept.end(), object.get()) != kept.end())
      continue;
    HairInternals& internals = *object->internals_;
    internals.resetPending = true;
    internals.followContacts.forget();
    internals.grid.remove(room());
    object->buffers_.contactForces = BufferId::kInvalid;
  }
  for (const auto& collider : sdfs_.colliders) {
    if (collider != nullptr) collider->internals_->resetPending = true;
  }
  for (const auto& skeleton : skeletons_) {
    if (skeleton == nullptr) continue;
    for (auto& copy : skeleton->internals_->copies) copy.version = 0;
  }
}

}  // namespace pelage::detail
