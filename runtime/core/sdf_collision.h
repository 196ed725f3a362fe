// The passes that move vertices out of distance fields.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage::detail {

struct SdfCollisionBuffers {
  BufferId positions = BufferId::kInvalid, before = BufferId::kInvalid;
  BufferId fields = BufferId::kInvalid, keys = BufferId::kInvalid, surface = BufferId::kInvalid;
  /// Of sdfNearBytes(), for indirect arguments and uploads; only where only near vertices collide.
  BufferId nearList = BufferId::kInvalid;
};

struct SdfCollisionDef {
  uint32_t vertexCount = 0;
  uint32_t fieldCount = 0;
  float begin = 0, end = 1;  ///< shares of the frame, as ApplySdfConstants has them
  bool friction = true;
  bool walk = true;  ///< from the triangles that nodes know to nearer ones beside them
  /// Lists the vertices near a surface first, so that only they run the whole query: the same bits.
  /// Slower where nearly all vertices are near.
  bool onlyNear = true;
};

uint64_t sdfNearBytes(uint32_t vertexCount);

Result<void> addSdfCollision(PassList& list, const ResourceTable& resources,
                             const SdfCollisionBuffers& buffers, const SdfCollisionDef& def);

}  // namespace pelage::detail
