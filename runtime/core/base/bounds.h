// Boxes and balls for tests of proximity.
#pragma once

#include "base/finite.h"
#include "pelage/types.h"

namespace pelage::detail {

/// The distance of two points.
float distance(const Float3& a, const Float3& b);

struct Ball {
  Float3 center = {};
  float radius = 0;
};

/// An axis-aligned box; empty while low > high.
struct Box {
  Float3 low = {1, 1, 1};
  Float3 high = {-1, -1, -1};
  bool isEmpty() const { return low.x > high.x; }
};

Float3 middleOf(const Box& box);
Box include(const Box& box, const Float3& point);
Box include(const Box& a, const Box& b);
bool isFinite(const Box& box);
/// Returns true if `inner` with its margin [m] is in `outer`.
bool isInside(const Box& inner, const Box& outer, float margin);
bool reaches(const Box& box, const Ball& ball);

}  // namespace pelage::detail
