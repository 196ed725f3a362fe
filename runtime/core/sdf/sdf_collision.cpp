#include "sdf/sdf_collision.h"

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

Result<void> addSdfCollision(PassList& list, const ResourceTable& resources,
                             const SdfCollisionBuffers& buffers, const SdfCollisionDef& def) {
  if (def.vertexCount == 0 || def.contactSdfCount == 0) return {};
  ApplySdfConstants constants = {};
  constants.sdfVertexCount = def.vertexCount;
  constants.sdfCount = def.contactSdfCount;
  constants.sdfBegin = def.begin;
  constants.sdfEnd = def.end;
  const KernelVariant& collide = collideVerticesVariant({.closestFeature = def.closestFeature});
  PassBuilder builder(list);
  return dispatchRows(builder, collide, def.vertexCount)
      .finish(ApplySDFBindings{
          .applySdfConstants = constants,
          .sdfs = resources.whole(buffers.sdfs),
          .sdfKeys = resources.whole(buffers.keys),
          .sdfSurface = resources.whole(buffers.surface),
          .sdfPositions = resources.whole(buffers.positions),
          .sdfPositionsBefore = resources.whole(buffers.before),
      });
}

}  // namespace pelage::detail
