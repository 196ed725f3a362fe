#include "contact/follow_contacts.h"

#include <algorithm>
#include <span>
#include <utility>

#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/hair_buffers.h"
#include "pelage/kernels.h"

namespace pelage {

using namespace follow_collision;

FollowContactCounters readFollowContactCounters(std::span<const std::byte> words) {
  uint32_t head[kFollowHeadWords] = {};
  const size_t bytes = std::min(words.size(), sizeof(head));
  std::copy_n(words.begin(), bytes, std::as_writable_bytes(std::span(head)).begin());
  return {.records = head[kFollowRecords], .strandsWalkedAgain = head[kFollowMarked]};
}

namespace detail {

uint32_t FollowContacts::tiles() const {
  return (strands_ + kFollowTileStrands - 1) / kFollowTileStrands;
}

uint32_t FollowContacts::rows() const {
  return (vertices_ + kFollowRowVertices - 1) / kFollowRowVertices;
}

uint64_t FollowContacts::wordBytes() const {
  return (kFollowHeadWords + 2 * uint64_t{tiles()} + uint64_t{rows()} * strands_) *
         sizeof(uint32_t);
}

void FollowContacts::makeBuffers(const HairFrame& frame) {
  strands_ = frame.followCount;
  vertices_ = frame.vertexCount;
  const auto add = [&](const char* what, uint64_t bytes, uint32_t stride, BufferUsage usage) {
    return frame.factory.resources.add(
        {.name = frame.name + "/" + what, .size = bytes, .stride = stride, .usage = usage});
  };
  before_ = add("followBefore", beforeBytes(), sizeof(Float4), BufferUsage::kStorage);
  contacts_ = add("followContacts", contactBytes(), sizeof(FollowContact), BufferUsage::kStorage);
  words_ = add("followContactWords", wordBytes(), sizeof(uint32_t),
               BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
                   BufferUsage::kReadback);
}

Result<void> FollowContacts::record(HairFrame& frame, const ColliderBuffers& colliders) {
  const bool known = std::exchange(goesOn_, false) && !frame.reset;
  if (!frame.groom.collidesFollowHairs || !colliders.any()) return {};
  if (words_ == BufferId::kInvalid) {
    makeBuffers(frame);
    frame.buffers.followBefore = before_;
    frame.buffers.followContactWords = words_;
  }
  goesOn_ = true;
  uint32_t head[kFollowHeadWords] = {};
  head[kFollowArguments + 1] = rows();
  head[kFollowArguments + 2] = 1;
  addUpload(frame.list, words_, std::as_bytes(std::span(head)));
  const Float3 origin = frame.origin.world();
  FollowCollisionConstants constants = {};
  constants.followOrigin = {origin.x, origin.y, origin.z, 0};
  constants.firstFollow = frame.guideCount;
  constants.followHairCount = strands_;
  constants.followVertexCount = vertices_;
  constants.followSdfCount = colliders.contactSdfCount;
  constants.followColliderCount = colliders.capsuleCount;
  constants.followHistory = known ? 1 : 0;
  constants.followTileCount = tiles();
  const KernelVariant& find = *findFollowContactsVariant(
      {.sdf = colliders.contactSdfCount > 0, .denseSdf = colliders.hasDenseSdfs});
  const KernelVariant& walk = collideFollowHairsVariant({});
  for (const bool again : {false, true}) {
    constants.followAgain = again ? 1 : 0;
    for (const KernelVariant* variant : {&find, &walk}) {
      Result<void> added = addPass(frame, *variant, colliders, constants);
      if (!added) return added;
    }
  }
  return {};
}

Result<void> FollowContacts::addPass(const HairFrame& frame, const KernelVariant& variant,
                                     const ColliderBuffers& colliders,
                                     const FollowCollisionConstants& constants) const {
  const bool walks = &variant == &collideFollowHairsVariant({});
  const ResourceTable& resources = frame.factory.resources;
  const uint64_t stored = (uint64_t{frame.guideCount} + strands_) * vertices_ * sizeof(Float4);
  PassBuilder builder(frame.list);
  if (constants.followAgain != 0)
    builder.dispatchIndirect(variant, words_, kFollowArguments * sizeof(uint32_t));
  else if (frame.sleeps)
    builder.dispatchIndirect(variant, frame.buffers.sleep,
                             exact::kSleepFollowArguments * sizeof(uint32_t));
  else
    builder.dispatch(variant, tiles() * variant.groupSize[0],
                     walks ? 1 : rows() * variant.groupSize[1]);
  builder.bytes(constants.followAgain != 0 ? 0 : 3 * vertices() * sizeof(Float4));
  return builder.finish(FollowCollisionBindings{
      .followCollisionConstants = constants,
      .followSdfs = {colliders.sdfs, colliders.contactSdfCount * sizeof(Sdf)},
      .followKeys = resources.whole(colliders.contactSdfKeys),
      .followSurface = resources.whole(colliders.contactSdfSurface),
      .followColliders = resources.whole(colliders.capsules),
      .followPositions = {frame.buffers.positions, stored},
      .followTangents = {frame.buffers.tangents, stored},
      .followBefore = {before_, beforeBytes()},
      .followContacts = {contacts_, contactBytes()},
      .followWords = {words_, wordBytes()},
  });
}

}  // namespace detail
}  // namespace pelage
