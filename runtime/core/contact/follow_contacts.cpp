#include "contact/follow_contacts.h"

#include <algorithm>
#include <span>

#include "pelage/hair_object.h"
#include "pelage/kernels.h"

namespace pelage {
namespace {

// As in kernels/layouts/follow_collision.hlsli.
constexpr uint32_t kTileStrands = 32, kRowVertices = 16, kHeadWords = 8, kArguments = 4;

}  // namespace

FollowContactCounters readFollowContactCounters(std::span<const std::byte> words) {
  uint32_t head[2] = {};
  const size_t bytes = std::min(words.size(), sizeof(head));
  std::copy_n(words.begin(), bytes, std::as_writable_bytes(std::span(head)).begin());
  return {.records = head[0], .strandsWalkedAgain = head[1]};
}

namespace detail {

uint32_t FollowContacts::tiles() const { return (strands_ + kTileStrands - 1) / kTileStrands; }

uint32_t FollowContacts::rows() const { return (vertices_ + kRowVertices - 1) / kRowVertices; }

uint64_t FollowContacts::wordBytes() const {
  return (kHeadWords + 2 * uint64_t{tiles()} + uint64_t{rows()} * strands_) * sizeof(uint32_t);
}

void FollowContacts::prepare(ResourceTable& resources, const std::string& name, uint32_t strands,
                             uint32_t verticesPerStrand) {
  strands_ = strands;
  vertices_ = verticesPerStrand;
  const auto add = [&](const char* what, uint64_t bytes, uint32_t stride, BufferUsage usage) {
    return resources.add(
        {.name = name + "/" + what, .size = bytes, .stride = stride, .usage = usage});
  };
  before_ = add("followBefore", beforeBytes(), sizeof(Float4), BufferUsage::kStorage);
  contacts_ = add("followContacts", contactBytes(), sizeof(FollowContact), BufferUsage::kStorage);
  words_ = add("followContactWords", wordBytes(), sizeof(uint32_t),
               BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
                   BufferUsage::kReadback);
}

Result<void> FollowContacts::add(PassList& list, const ResourceTable& resources,
                                 const FollowHairs& hairs, const ColliderBuffers& colliders,
                                 bool known) {
  const uint32_t head[kHeadWords] = {0, 0, 0, 0, 0, rows(), 1, 0};
  addUpload(list, words_, std::as_bytes(std::span(head)));
  FollowCollisionConstants constants = {};
  constants.followOrigin = {hairs.origin.x, hairs.origin.y, hairs.origin.z, 0};
  constants.firstFollow = hairs.first;
  constants.followStrandCount = strands_;
  constants.followVertexCount = vertices_;
  constants.followFieldCount = colliders.fieldCount;
  constants.followColliderCount = colliders.capsuleCount;
  constants.followHistory = known ? 1 : 0;
  constants.followTileCount = tiles();
  const KernelVariant& find = findFollowContactsVariant({.sdf = colliders.fieldCount > 0});
  const KernelVariant& walk = collideFollowStrandsVariant({});
  for (const bool again : {false, true}) {
    constants.followAgain = again ? 1 : 0;
    for (const KernelVariant* variant : {&find, &walk}) {
      Result<void> added = addPass(list, resources, *variant, hairs, colliders, constants);
      if (!added) return added;
    }
  }
  return {};
}

Result<void> FollowContacts::addPass(PassList& list, const ResourceTable& resources,
                                     const KernelVariant& variant, const FollowHairs& hairs,
                                     const ColliderBuffers& colliders,
                                     const FollowCollisionConstants& constants) const {
  const auto sizeOf = [&](BufferId id) {
    const BufferDesc* desc = resources.find(id);
    return desc == nullptr ? 0 : desc->size;
  };
  const bool walks = &variant == &collideFollowStrandsVariant({});
  const uint64_t stored = (uint64_t{hairs.first} + strands_) * vertices_ * sizeof(Float4);
  PassBuilder builder(list);
  if (constants.followAgain != 0)
    builder.dispatchIndirect(variant, words_, kArguments * sizeof(uint32_t));
  else if (hairs.awake != BufferId::kInvalid)
    builder.dispatchIndirect(variant, hairs.awake, hairs.argumentBytes);
  else
    builder.dispatch(variant, tiles() * variant.groupSize[0],
                     walks ? 1 : rows() * variant.groupSize[1]);
  builder.bind("g_followPositions", hairs.positions, stored)
      .bind("g_followTangents", hairs.tangents, stored)
      .bind("g_followBefore", before_, beforeBytes())
      .bind("g_followContacts", contacts_, contactBytes())
      .bind("g_followWords", words_, wordBytes())
      .bind("g_followFields", colliders.fields, colliders.fieldCount * sizeof(SdfField))
      .bind("g_followKeys", colliders.fieldKeys, sizeOf(colliders.fieldKeys))
      .bind("g_followSurface", colliders.fieldSurface, sizeOf(colliders.fieldSurface))
      .bind("g_followColliders", colliders.capsules, sizeOf(colliders.capsules))
      .constants("FollowCollisionConstants", constants)
      .bytes(constants.followAgain != 0 ? 0 : 3 * vertices() * sizeof(Float4));
  return builder.finish();
}

}  // namespace detail
}  // namespace pelage
