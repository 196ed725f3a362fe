// What a scene goes on from when its device is lost: what the host has, and what was read back.
#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene_impl.h"

namespace pelage {

namespace detail {

struct BufferContents {
  BufferId buffer = BufferId::kInvalid;
  std::vector<std::byte> bytes;
};

struct HairSnapshot {
  HairId id = {};
  HairFrameState state;
  HairBuffers buffers;
  std::vector<BufferContents> contents;
};

struct SnapshotData {
  uint64_t table = 0;  // ResourceTable::id()
  double time = 0;
  Vector3<double> shifted;
  std::vector<HairSnapshot> hairs;
};

// Buffers of an object alone, with what the GPU has written.
std::vector<BufferId> SceneImpl::ownBuffers(const HairObject& object) {
  HairBuffers buffers = object.buffers_;
  HairFrameState state = *object.internals_;
  HostArray<RemovedBuffer> removed;
  removeHairBuffers(buffers, state, object.internals_->skeleton != nullptr,
                    {resources_, hazards_, &removed});
  std::vector<BufferId> own;
  for (const RemovedBuffer& buffer : removed)
    if (!shared_.contains(buffer.buffer)) own.push_back(buffer.buffer);
  std::sort(own.begin(), own.end());
  return own;
}

Result<std::shared_ptr<const SnapshotData>> SceneImpl::takeSnapshot(const BufferReader& read) {
  settleFrames(false);
  const auto ran = [](const FrameCheckpoint& frame) {
    return !frame.abandoned && frame.run != nullptr && stateOf(*frame.run) == RunState::kDelivered;
  };
  if (!std::all_of(frames_.open.begin(), frames_.open.end(), ran)) {
    return Error{ErrorCode::kInvalidArgument,
                 "takeSnapshot(): a frame has not run yet: take it behind a frame that the device "
                 "has finished"};
  }
  auto data = std::make_shared<SnapshotData>();
  data->table = resources_.id();
  data->time = time_;
  data->shifted = shifted();
  for (size_t i = 0; i < objects_.size(); ++i) {
    const HairObject* object = objects_[i];
    // One that is to be reset has nothing to keep.
    if (object == nullptr || object->internals_->resetPending) continue;
    HairSnapshot& hair = data->hairs.emplace_back();
    hair.id = objects_.idOf(i);
    hair.state = *object->internals_;
    hair.buffers = object->buffers_;
    for (const BufferId buffer : ownBuffers(*object)) {
      Result<std::vector<std::byte>> bytes = read(buffer);
      if (!bytes) return bytes.error();
      const BufferDesc& desc = *resources_.find(buffer);
      if (bytes->size() != desc.size) {
        return Error{ErrorCode::kInvalidArgument, "takeSnapshot(): the reader gave " +
                                                      std::to_string(bytes->size()) +
                                                      " bytes of buffer '" + desc.name +
                                                      "', which has " + std::to_string(desc.size)};
      }
      hair.contents.push_back({buffer, std::move(*bytes)});
    }
  }
  return std::shared_ptr<const SnapshotData>(std::move(data));
}

// A change of the solver, of settings or of the rest pose has made other buffers since.
bool SceneImpl::hasBuffersOf(const HairObject& object, const HairSnapshot& saved) {
  using Ids = std::array<BufferId, sizeof(HairBuffers) / sizeof(BufferId)>;
  HairBuffers then = saved.buffers;
  then.forces = object.buffers_.forces;
  if (std::bit_cast<Ids>(then) != std::bit_cast<Ids>(object.buffers_)) return false;
  const std::vector<BufferId> own = ownBuffers(object);
  return std::equal(
      own.begin(), own.end(), saved.contents.begin(), saved.contents.end(),
      [](BufferId buffer, const BufferContents& contents) { return buffer == contents.buffer; });
}

// Takes an object back to a snapshot.
void SceneImpl::restoreHair(HairInternals& hair, const HairFrameState& state,
                            const Vector3<double>& shifted) {
  static_cast<HairFrameState&>(hair) = state;
  const Vector3<double> since = this->shifted() - shifted;
  // Bones, colliders and fields of the engine are where they are now.
  const bool moved = since.x != 0 || since.y != 0 || since.z != 0;
  if (moved) shiftWorld(static_cast<HairFrameState&>(hair), since, this->shifted());
  sendAgain(hair);
}

Result<uint32_t> SceneImpl::recover(const SnapshotData* snapshot) {
  if (snapshot != nullptr && snapshot->table != resources_.id()) {
    return Error{ErrorCode::kInvalidArgument, "recover(): the snapshot is of another scene"};
  }
  settleFrames(true);
  while (!frames_.open.empty()) restoreFrame();
  draws_.trim(room(), "its device was lost; write it again");
  std::vector<HairObject*> kept;
  for (size_t i = 0; snapshot != nullptr && i < snapshot->hairs.size(); ++i) {
    const HairSnapshot& saved = snapshot->hairs[i];
    HairObject* object = objects_.find(saved.id);
    if (object == nullptr || object->internals_->resetPending) continue;
    if (!hasBuffersOf(*object, saved)) continue;
    for (const BufferContents& contents : saved.contents)
      resources_.setInitial(contents.buffer, contents.bytes);
    restoreHair(*object->internals_, saved.state, snapshot->shifted);
    kept.push_back(object);
  }
  if (!kept.empty()) time_ = snapshot->time;
  sendEverything(kept);
  return static_cast<uint32_t>(kept.size());
}

}  // namespace detail

Result<SceneSnapshot> Scene::takeSnapshot(const BufferReader& read) const {
  auto data = impl_->takeSnapshot(read);
  if (!data) return data.error();
  SceneSnapshot snapshot;
  snapshot.data_ = std::move(*data);
  return snapshot;
}

uint64_t SceneSnapshot::bytes() const {
  uint64_t sum = 0;
  if (data_ == nullptr) return sum;
  for (const detail::HairSnapshot& hair : data_->hairs)
    for (const detail::BufferContents& contents : hair.contents) sum += contents.bytes.size();
  return sum;
}

Result<uint32_t> Scene::recover(const SceneSnapshot& snapshot) {
  return impl_->recover(snapshot.data_.get());
}

}  // namespace pelage
