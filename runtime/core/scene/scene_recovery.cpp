// Recovery of a scene whose device is lost, from the host's data and a snapshot.
#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene_parts.h"

namespace pelage {

namespace detail {

struct BufferContents {
  BufferId buffer = BufferId::kInvalid;
  std::vector<std::byte> bytes;
};

struct HairSnapshot {
  HairId id = {};
  HairFrameState state;
  HairOutputs buffers;
  std::vector<BufferContents> contents;
};

struct SnapshotData {
  uint64_t table = 0;  // ResourceTable::id()
  double time = 0;
  Vector3<double> shifted;
  std::vector<HairSnapshot> hairs;
};

namespace {

// Buffers that belong to one object alone, and that the GPU writes.
std::vector<BufferId> ownBuffers(HairStore& store, const HairObject& object) {
  const HairInternals& hair = HairStore::of(object);
  HairBuffers buffers = object.buffers();
  HairFrameState state = hair;
  HostArray<RemovedBuffer> removed;
  removeHairBuffers(buffers, state, hair.skeleton != nullptr,
                    {store.resources, store.hazards, &removed});
  std::vector<BufferId> own;
  for (const RemovedBuffer& buffer : removed)
    if (!store.shared.contains(buffer.buffer)) own.push_back(buffer.buffer);
  std::sort(own.begin(), own.end());
  return own;
}

Result<std::vector<BufferContents>> contentsOf(HairStore& store, const HairObject& object,
                                               const BufferReader& read) {
  std::vector<BufferContents> contents;
  for (const BufferId buffer : ownBuffers(store, object)) {
    Result<std::vector<std::byte>> bytes = read(buffer);
    if (!bytes) return bytes.error();
    const BufferDesc& desc = *store.resources.find(buffer);
    if (bytes->size() != desc.size) {
      return Error{ErrorCode::kInvalidArgument, "takeSnapshot(): the reader gave " +
                                                    std::to_string(bytes->size()) +
                                                    " bytes of buffer '" + desc.name +
                                                    "', which has " + std::to_string(desc.size)};
    }
    contents.push_back({buffer, std::move(*bytes)});
  }
  return contents;
}

// False where a change of the solver, of settings or of the rest pose has made other buffers since.
bool hasBuffersOf(HairStore& store, const HairObject& object, const HairSnapshot& saved) {
  using Ids = std::array<BufferId, sizeof(HairOutputs) / sizeof(BufferId)>;
  const HairOutputs& now = object.buffers();
  if (std::bit_cast<Ids>(saved.buffers) != std::bit_cast<Ids>(now)) return false;
  const std::vector<BufferId> own = ownBuffers(store, object);
  return std::equal(
      own.begin(), own.end(), saved.contents.begin(), saved.contents.end(),
      [](BufferId buffer, const BufferContents& contents) { return buffer == contents.buffer; });
}

// \param shifted  of the world, as it was then
void restoreHair(const HairStore& store, HairInternals& hair, const HairFrameState& state,
                 const Vector3<double>& shifted) {
  static_cast<HairFrameState&>(hair) = state;
  const Vector3<double> since = store.shifted - shifted;
  // Bones, colliders and fields of the engine are where they are now.
  const bool moved = since.x != 0 || since.y != 0 || since.z != 0;
  if (moved) shiftWorld(static_cast<HairFrameState&>(hair), since, store.shifted);
  sendAgain(hair);
}

// The objects that go on from the snapshot.
std::vector<HairObject*> restoreHairs(HairStore& store, const SnapshotData& snapshot) {
  std::vector<HairObject*> kept;
  for (const HairSnapshot& saved : snapshot.hairs) {
    HairObject* object = store.hairSlots.find(saved.id);
    if (object == nullptr || HairStore::of(*object).resetPending) continue;
    if (!hasBuffersOf(store, *object, saved)) continue;
    for (const BufferContents& contents : saved.contents)
      store.resources.setInitial(contents.buffer, contents.bytes);
    restoreHair(store, HairStore::of(*object), saved.state, snapshot.shifted);
    kept.push_back(object);
  }
  return kept;
}

}  // namespace
}  // namespace detail

Result<SceneSnapshot> Scene::takeSnapshot(const BufferReader& read) const {
  if (!read)
    return Error{ErrorCode::kInvalidArgument, "takeSnapshot(): the reader is empty: give one"};
  detail::HairStore& store = parts_->store;
  parts_->journal.settle(false);
  if (!parts_->journal.allHaveRun()) {
    return Error{ErrorCode::kInvalidArgument,
                 "takeSnapshot(): a frame has not run yet: take it behind a frame that the device "
                 "has finished"};
  }
  auto data = std::make_shared<detail::SnapshotData>();
  data->table = store.resources.id();
  data->time = store.time;
  data->shifted = store.shifted;
  for (size_t i = 0; i < store.hairSlots.size(); ++i) {
    const HairObject* object = store.hairSlots[i];
    // A reset keeps nothing.
    if (object == nullptr || detail::HairStore::of(*object).resetPending) continue;
    Result<std::vector<detail::BufferContents>> contents = detail::contentsOf(store, *object, read);
    if (!contents) return contents.error();
    data->hairs.push_back({.id = store.hairSlots.idOf(i),
                           .state = detail::HairStore::of(*object),
                           .buffers = object->buffers(),
                           .contents = std::move(*contents)});
  }
  SceneSnapshot snapshot;
  snapshot.data_ = std::move(data);
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
  detail::HairStore& store = parts_->store;
  const detail::SnapshotData* data = snapshot.data_.get();
  if (data != nullptr && data->table != store.resources.id())
    return Error{ErrorCode::kInvalidArgument, "recover(): the snapshot is of another scene"};
  parts_->journal.settle(true);
  parts_->journal.takeBackAll();
  parts_->drawing.trim("its device was lost; write it again");
  std::vector<HairObject*> kept;
  if (data != nullptr) kept = detail::restoreHairs(store, *data);
  if (!kept.empty()) store.time = data->time;
  parts_->journal.resetAll(kept);
  store.hazards.forgetExecutor();
  return static_cast<uint32_t>(kept.size());
}

}  // namespace pelage
