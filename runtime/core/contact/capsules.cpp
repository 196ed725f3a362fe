#include "contact/capsules.h"

#include <algorithm>
#include <cmath>

#include "base/vector3.h"

namespace pelage::detail {
namespace {

bool isValid(const CapsuleCollider& c) {
  return isFinite(c.head) && isFinite(c.tail) && std::isfinite(c.headRadius) &&
         std::isfinite(c.tailRadius) && std::isfinite(c.friction) && c.headRadius >= 0 &&
         c.tailRadius >= 0 && c.friction >= 0 && isFinite(c.angularVelocity);
}

// Rotation vector of a frame: of a capsule only what is about its axis.
Float4 spinOf(const CapsuleCollider& c, float seconds) {
  const Float3 w = c.angularVelocity;
  const Float3 axis = {c.tail.x - c.head.x, c.tail.y - c.head.y, c.tail.z - c.head.z};
  const float squared = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z;
  if (!(squared > 0)) return {w.x * seconds, w.y * seconds, w.z * seconds, 0};
  const float share = (w.x * axis.x + w.y * axis.y + w.z * axis.z) / squared * seconds;
  return {axis.x * share, axis.y * share, axis.z * share, 0};
}

bool reaches(const CapsuleCollider& c, const Ball& ball) {
  const float radius = std::max(c.headRadius, c.tailRadius) + 0.5f * distance(c.head, c.tail);
  const Float3 center = {0.5f * (c.head.x + c.tail.x), 0.5f * (c.head.y + c.tail.y),
                         0.5f * (c.head.z + c.tail.z)};
  return !(distance(center, ball.center) > radius + ball.radius);
}

}  // namespace

bool areReplaced(std::span<const CapsuleCollider> before, std::span<const CapsuleCollider> now) {
  return !std::equal(before.begin(), before.end(), now.begin(), now.end(),
                     [](const CapsuleCollider& a, const CapsuleCollider& b) {
                       return isValid(a) == isValid(b) && a.headRadius == b.headRadius &&
                              a.tailRadius == b.tailRadius && a.friction == b.friction;
                     });
}

size_t packCapsules(std::span<const CapsuleCollider> capsules,
                    std::span<const CapsuleCollider> capsulesBefore, const LocalOrigin& origin,
                    const Ball& ball, float seconds, std::span<Collider> packed) {
  const auto relative = [&](Float3 p, float w) {
    const Float3 r = origin.relative(p);
    return Float4{r.x, r.y, r.z, w};
  };
  const auto pack = [&](const CapsuleCollider& now, const CapsuleCollider& before) {
    return Collider{.head = relative(now.head, now.headRadius),
                    .tail = relative(now.tail, now.tailRadius),
                    .headBefore = relative(before.head, now.friction),
                    .tailBefore = relative(before.tail, 0),
                    .spin = spinOf(now, seconds)};
  };
  size_t count = 0;
  for (size_t i = 0; i < capsules.size(); ++i) {
    const CapsuleCollider& now = capsules[i];
    if (!isValid(now)) continue;
    const bool known = i < capsulesBefore.size() && isValid(capsulesBefore[i]);
    const CapsuleCollider& before = known ? capsulesBefore[i] : now;
    if (!reaches(now, ball) && !reaches(before, ball)) continue;
    if (const size_t at = count++; at < packed.size()) packed[at] = pack(now, before);
  }
  return count;
}

double wayInRadii(std::span<const CapsuleCollider> capsules,
                  std::span<const CapsuleCollider> capsulesBefore, const Ball& ball,
                  const BoneMoves& moves, double enough) {
  constexpr float kThinnest = 1e-3f;  // [m]
  double most = 0;
  for (size_t i = 0; i < std::min(capsules.size(), capsulesBefore.size()); ++i) {
    const CapsuleCollider& now = capsules[i];
    const CapsuleCollider& before = capsulesBefore[i];
    if (!isValid(now) || !isValid(before)) continue;
    if (!reaches(now, ball) && !reaches(before, ball)) continue;
    const float radius = std::max(std::min(now.headRadius, now.tailRadius), kThinnest);
    const float way =
        moves.leastWay(static_cast<float>(enough) * radius, [&](const AffineTransform& move) {
          return std::max(distance(now.head, transformPoint(move, before.head)),
                          distance(now.tail, transformPoint(move, before.tail)));
        });
    most = std::max(most, double{way} / double{radius});
  }
  return most;
}

void moveCapsules(std::span<CapsuleCollider> capsules, const WorldMove& move) {
  for (CapsuleCollider& capsule : capsules) {
    move.point(capsule.head);
    move.point(capsule.tail);
    move.direction(capsule.angularVelocity);
  }
}

void settleCapsules(std::span<CapsuleCollider> before, std::span<const CapsuleCollider> now,
                    double roundedShift) {
  constexpr double kRounding = 0x1p-23;
  const auto settle = [&](Float3& from, const Float3& to) {
    const double largest =
        static_cast<double>(std::max({std::abs(to.x), std::abs(to.y), std::abs(to.z)}));
    const double limit = kRounding * (roundedShift + 2 * largest);
    const Vector3<double> moved = toVector(to) - toVector(from);
    if (std::max({std::abs(moved.x), std::abs(moved.y), std::abs(moved.z)}) <= limit) from = to;
  };
  for (size_t i = 0; i < std::min(now.size(), before.size()); ++i) {
    settle(before[i].head, now[i].head);
    settle(before[i].tail, now[i].tail);
  }
}

}  // namespace pelage::detail
