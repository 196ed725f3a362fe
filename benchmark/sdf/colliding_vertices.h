// What a baseline's or pelage's SDF moves out.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"

namespace bench {

/// Positions that collide, now and a frame ago: [vertex] Float4. All of them end where they are.
struct CollidingVertices {
  pelage::BufferId positions = pelage::BufferId::kInvalid;
  pelage::BufferId before = pelage::BufferId::kInvalid;
  uint32_t count = 0;
};

}  // namespace bench
