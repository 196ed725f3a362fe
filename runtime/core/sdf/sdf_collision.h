// The passes that move vertices out of distance fields.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage::detail {

struct SdfCollisionBuffers {
  BufferId positions = BufferId::kInvalid, before = BufferId::kInvalid;
  BufferId sdfs = BufferId::kInvalid, keys = BufferId::kInvalid, surface = BufferId::kInvalid;
};

struct SdfCollisionDef {
  uint32_t vertexCount = 0;
  uint32_t contactSdfCount = 0;
  float begin = 0, end = 1;    ///< shares of the frame, as ApplySdfConstants has them
  bool closestFeature = true;  ///< else the trilinear distance and its gradient
};

Result<void> addSdfCollision(PassList& list, const ResourceTable& resources,
                             const SdfCollisionBuffers& buffers, const SdfCollisionDef& def);

}  // namespace pelage::detail
