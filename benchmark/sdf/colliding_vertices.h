// Vertices that an SDF moves out of its mesh: pelage's or a baseline's.
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
