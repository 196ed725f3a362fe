#include "sdf_collision.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

// Threads in x, as in kernels/sdf/collide_vertices.hlsl.
constexpr uint32_t kRow = 1u << 20;
// As in kernels/sdf/sdf_near_list.hlsli.
constexpr std::array<uint32_t, 4> kNoneNear = {0, 1, 1, 0};

}  // namespace

uint64_t sdfNearBytes(uint32_t vertexCount) {
  return (kNoneNear.size() + uint64_t{vertexCount}) * sizeof(uint32_t);
}

Result<void> addSdfCollision(PassList& list, const ResourceTable& resources,
                             const SdfCollisionBuffers& buffers, const SdfCollisionDef& def) {
  if (def.vertexCount == 0 || def.fieldCount == 0) return {};
  ApplySdfConstants constants = {};
  constants.sdfVertexCount = def.vertexCount;
  constants.sdfFieldCount = def.fieldCount;
  constants.sdfBegin = def.begin;
  constants.sdfEnd = def.end;
  const std::pair<const char*, BufferId> all[] = {
      {"g_sdfPositions", buffers.positions}, {"g_sdfPositionsBefore", buffers.before},
      {"g_sdfFields", buffers.fields},       {"g_sdfKeys", buffers.keys},
      {"g_sdfSurface", buffers.surface},     {"g_sdfNear", buffers.nearList}};
  const auto finish = [&](PassBuilder& builder) {
    for (const auto& [name, buffer] : all)
      if (const BufferDesc* desc = resources.find(buffer)) builder.bind(name, buffer, desc->size);
    return builder.constants("ApplySdfConstants", constants).finish();
  };
  const uint32_t x = std::min(def.vertexCount, kRow), y = (def.vertexCount + kRow - 1) / kRow;
  const KernelVariant* collide =
      collideVerticesVariant({.closestFeature = true,
                              .friction = def.friction,
                              .walk = def.walk ? CollideVerticesWalk::k4 : CollideVerticesWalk::k0,
                              .listed = def.onlyNear});
  if (def.onlyNear) {
    addUpload(list, buffers.nearList, std::as_bytes(std::span(kNoneNear)));
    PassBuilder search(list);
    search.dispatch(findNearVerticesVariant({}), x, y);
    if (Result<void> done = finish(search); !done) return done;
  }
  PassBuilder builder(list);
  if (def.onlyNear)
    builder.dispatchIndirect(*collide, buffers.nearList, 0);
  else
    builder.dispatch(*collide, x, y);
  return finish(builder);
}

}  // namespace pelage::detail
