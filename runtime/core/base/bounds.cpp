#include "base/bounds.h"

#include <algorithm>
#include <cmath>

namespace pelage::detail {

Float3 middleOf(const Box& box) {
  return {0.5f * (box.low.x + box.high.x), 0.5f * (box.low.y + box.high.y),
          0.5f * (box.low.z + box.high.z)};
}

Box include(const Box& box, const Float3& p) {
  if (box.isEmpty()) return {p, p};
  return {{std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)},
          {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)}};
}

Box include(const Box& a, const Box& b) {
  return b.isEmpty() ? a : include(include(a, b.low), b.high);
}

float distance(const Float3& a, const Float3& b) {
  const Float3 d = {a.x - b.x, a.y - b.y, a.z - b.z};
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

bool isFinite(const Box& box) { return isFinite(box.low) && isFinite(box.high); }

bool isInside(const Box& inner, const Box& outer, float margin) {
  return inner.low.x - margin >= outer.low.x && inner.low.y - margin >= outer.low.y &&
         inner.low.z - margin >= outer.low.z && inner.high.x + margin <= outer.high.x &&
         inner.high.y + margin <= outer.high.y && inner.high.z + margin <= outer.high.z;
}

bool reaches(const Box& box, const Ball& ball) {
  if (box.isEmpty()) return false;
  const auto away = [](float low, float high, float p) {
    return std::max({low - p, p - high, 0.0f});
  };
  const float x = away(box.low.x, box.high.x, ball.center.x);
  const float y = away(box.low.y, box.high.y, ball.center.y);
  const float z = away(box.low.z, box.high.z, ball.center.z);
  // A value that is not finite may be anywhere.
  return !(x * x + y * y + z * z > ball.radius * ball.radius);
}

}  // namespace pelage::detail
