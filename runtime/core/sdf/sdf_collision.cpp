#include "sdf/sdf_collision.h"

#include <algorithm>
#include <utility>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

// As in kernels/sdf/collide_vertices.hlsl.
constexpr uint32_t kRow = 1u << 20;  // vertices

}  // namespace

Result<void> addSdfCollision(PassList& list, const ResourceTable& resources,
                             const SdfCollisionBuffers& buffers, const SdfCollisionDef& def) {
  if (def.vertexCount == 0 || def.fieldCount == 0) return {};
  ApplySdfConstants constants = {};
  constants.sdfVertexCount = def.vertexCount;
  constants.sdfFieldCount = def.fieldCount;
  constants.sdfBegin = def.begin;
  constants.sdfEnd = def.end;
  const KernelVariant& collide = collideVerticesVariant({.closestFeature = def.closestFeature});
  const uint32_t row = std::min(def.vertexCount, kRow);
  PassBuilder builder(list);
  builder.dispatch(collide, row, (def.vertexCount + kRow - 1) / kRow);
  const std::pair<const char*, BufferId> all[] = {{"g_sdfPositions", buffers.positions},
                                                  {"g_sdfPositionsBefore", buffers.before},
                                                  {"g_sdfFields", buffers.fields},
                                                  {"g_sdfKeys", buffers.keys},
                                                  {"g_sdfSurface", buffers.surface}};
  for (const auto& [name, buffer] : all)
    if (const BufferDesc* desc = resources.find(buffer)) builder.bind(name, buffer, desc->size);
  return builder.constants("ApplySdfConstants", constants).finish();
}

}  // namespace pelage::detail
