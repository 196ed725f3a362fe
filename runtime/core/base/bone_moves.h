// Colliders move against hair that moves itself: these are the moves that they are compared with.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "pelage/skeleton.h"
#include "pelage/types.h"

namespace pelage::detail {

/// The moves of hair in a frame: of the middle of its roots, and of its bones.
struct BoneMoves {
  Float3 middle;                                 ///< [m]
  std::span<const AffineTransform> before, now;  ///< [bone]

  /// The way of something seen from the part of the hair that it moves the least against.
  /// \param enough  [m]; the search ends at the first that is not longer
  /// \param way     (AffineTransform) way against what moved so [m]; infinity or NaN if not known
  template <typename Way>
  float leastWay(float enough, Way way) const {
    AffineTransform move;
    move.rows[0].w = middle.x;
    move.rows[1].w = middle.y;
    move.rows[2].w = middle.z;
    float least = way(move);
    for (size_t bone = 0; bone < now.size() && !(least <= enough); ++bone) {
      if (const auto back = inverse(before[bone]))
        least = std::min(least, way(multiply(now[bone], *back)));
    }
    return least;
  }
};

}  // namespace pelage::detail
