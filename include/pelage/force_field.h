// A field of forces in space that an engine has on the GPU.
#pragma once

#include <array>
#include <cstdint>

#include "pelage/binding.h"
#include "pelage/types.h"

namespace pelage {

/// Accelerations on the nodes of a grid, in a buffer that your own pass writes: wind around a
/// character, an explosion, water. Between nodes they are interpolated linearly; outside of the
/// grid there are none.
struct ForceField {
  /// One of Scene::resources(): [z][y][x] Float4, xyz = acceleration a [m/s2], w = drag k [1/s], >=
  /// 0. The equation of motion gets a - k v; for air of velocity u, a = k u. kInvalid: no field.
  BufferId values = BufferId::kInvalid;
  uint32_t first = 0;                  ///< elements before node 0
  Float3 origin = {};                  ///< of node 0 in world space [m], finite
  float cellSize = 0;                  ///< distance between nodes [m], finite, > 0
  std::array<uint32_t, 3> nodes = {};  ///< along x, y, z, each >= 2
  bool operator==(const ForceField&) const = default;
};

}  // namespace pelage
