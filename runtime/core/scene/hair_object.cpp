#include "pelage/hair_object.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "pelage/assert.h"
#include "scene/hair_internals.h"

namespace pelage {

SimulationCounters readCounters(std::span<const std::byte> sleepWords) {
  uint32_t words[8] = {};
  PELAGE_ASSERT(sleepWords.size() >= sizeof(words), "the counters are in the first 32 bytes");
  std::memcpy(words, sleepWords.data(), std::min(sleepWords.size(), sizeof(words)));
  return {.awakeStrands = words[3], .secondPasses = words[7]};
}

HairObject::HairObject() : internals_(std::make_unique<detail::HairInternals>()) {}
HairObject::~HairObject() = default;

SkinningMethod HairObject::skinning() const { return internals_->skinning; }

void HairObject::setBones(std::span<const AffineTransform> bones) {
  PELAGE_ASSERT(internals_->skeleton == nullptr,
                "the bones are those of a skeleton: SkeletonPose::setBones()");
  PELAGE_ASSERT(bones.size() == boneCount_, "setBones() takes boneCount() transforms");
  const size_t count = std::min<size_t>(bones.size(), boneCount_);
  if (std::equal(bones.begin(), bones.begin() + static_cast<ptrdiff_t>(count),
                 internals_->bones.begin()))
    return;
  std::copy_n(bones.begin(), count, internals_->bones.begin());
  internals_->bonesChanged = true;
}

void HairObject::setColliders(std::span<const CapsuleCollider> colliders) {
  internals_->colliders.assign(colliders.begin(), colliders.end());
}

void HairObject::setMeshColliders(std::span<const ColliderId> colliders) {
  std::vector<ColliderId> set(colliders.begin(), colliders.end());
  std::sort(set.begin(), set.end());
  internals_->meshColliders = std::move(set);
}

void HairObject::useAllMeshColliders() { internals_->meshColliders.reset(); }

void HairObject::reset() { internals_->resetPending = true; }

namespace detail {
namespace {

// A root farther than this from the origin [m] moves it: the rounding of the state grows with the
// distance, and a new origin costs a pass over the state.
constexpr float kOriginRange = 1.5f;
// Larger coordinates [m] the kernels take for broken: isUsable() in common/quaternion.hlsli.
constexpr float kUsable = 1e18f;

bool isUsable(Float3 v) {
  return std::abs(v.x) < kUsable && std::abs(v.y) < kUsable && std::abs(v.z) < kUsable;
}

Float3 subtract(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

float distance(Float3 a, Float3 b) {
  const Float3 d = subtract(a, b);
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

Float3 apply(const AffineTransform& m, Float3 p) {
  const auto row = [&](const Float4& r) { return r.x * p.x + r.y * p.y + r.z * p.z + r.w; };
  return {row(m.rows[0]), row(m.rows[1]), row(m.rows[2])};
}

// Largest factor by which a transform can lengthen a vector, or a little more: the Frobenius norm.
float scaleOf(const AffineTransform& m) {
  float sum = 0;
  for (const Float4& r : m.rows) sum += r.x * r.x + r.y * r.y + r.z * r.z;
  return std::sqrt(sum);
}

bool isUsable(const CapsuleCollider& c) {
  return isFinite(c.head) && isFinite(c.tail) && std::isfinite(c.headRadius) &&
         std::isfinite(c.tailRadius) && std::isfinite(c.friction) && c.headRadius >= 0 &&
         c.tailRadius >= 0 && c.friction >= 0 && isFinite(c.angularVelocity);
}

// Rotation vector of a frame: of a capsule only what is about its axis.
Float4 spinOf(const CapsuleCollider& c, float seconds) {
  const Float3 w = c.angularVelocity;
  const Float3 axis = subtract(c.tail, c.head);
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

Ball ballOfStrands(const HairInternals& hair) {
  std::vector<Ball> balls;
  for (const BoneBounds& bounds : hair.bounds) {
    const AffineTransform& bone = hair.bones[bounds.bone];
    balls.push_back({apply(bone, bounds.center), bounds.radius * scaleOf(bone)});
    if (!isFinite(balls.back().center) || !std::isfinite(balls.back().radius))
      return {{}, INFINITY};
  }
  Ball all;
  for (const Ball& ball : balls) {
    const auto share = 1 / static_cast<float>(balls.size());
    all.center.x += ball.center.x * share;
    all.center.y += ball.center.y * share;
    all.center.z += ball.center.z * share;
  }
  for (const Ball& ball : balls)
    all.radius = std::max(all.radius, distance(all.center, ball.center) + ball.radius);
  // Blends of bones stay between what the bones do; rounding does not.
  all.radius = 1.01f * all.radius + hair.longestStrand;
  return all;
}

Ball ballOfCollisions(const HairInternals& hair, float tipSeparation) {
  return hair.collidesFollowHairs ? ballOfHair(hair, tipSeparation) : ballOfStrands(hair);
}

bool meets(const HairInternals& hair, ColliderId collider) {
  return !hair.meshColliders ||
         std::binary_search(hair.meshColliders->begin(), hair.meshColliders->end(), collider);
}

std::vector<BoneBounds> boundsOfRoots(const HairAsset& asset,
                                      std::span<const BoneInfluences> influences) {
  const size_t stride = asset.verticesPerStrand;
  const auto root = [&](uint32_t strand) {
    const Float4& p = asset.positions[strand * stride];
    return Float3{p.x, p.y, p.z};
  };
  std::vector<Box> boxes(1);
  const auto add = [&](uint32_t bone, Float3 p) {
    if (bone >= boxes.size()) boxes.resize(bone + 1);
    boxes[bone] = include(boxes[bone], p);
  };
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    bool bound = false;
    for (size_t k = 0; k < 4 && s < influences.size(); ++k) {
      if (!(influences[s].weights[k] > 0)) continue;
      add(influences[s].bones[k], root(s));
      bound = true;
    }
    if (!bound) add(s < influences.size() ? influences[s].bones[0] : 0, root(s));
  }
  std::vector<BoneBounds> bounds;
  for (uint32_t bone = 0; bone < boxes.size(); ++bone) {
    const Box& box = boxes[bone];
    if (box.isEmpty()) continue;
    const Float3 center = middleOf(box);
    bounds.push_back({bone, center, distance(center, box.high)});
  }
  return bounds;
}

float longestStrand(const HairAsset& asset) {
  float longest = 0;
  const size_t stride = asset.verticesPerStrand;
  for (size_t s = 0; s < asset.strandCount; ++s) {
    float length = 0;
    for (size_t i = 0; i < stride; ++i) length += asset.restLengths[s * stride + i];
    longest = std::max(longest, length);
  }
  return longest;
}

Float3 moveOrigin(HairInternals& hair) {
  if (hair.skeleton != nullptr) {
    const LocalOrigin old = hair.origin;
    hair.origin = hair.skeleton->origin;
    const bool known = std::exchange(hair.originKnown, true);
    if (!known || hair.origin.isAt(old)) return {};
    hair.bonesChanged = true;
    return between(old, hair.origin);
  }
  const BoneBounds& bounds = hair.bounds.front();
  const Float3 p = apply(hair.bones[bounds.bone], bounds.center);
  if (!isUsable(p)) {
    hair.originKnown = true;
    return {};
  }
  const Float3 away = hair.origin.relative(p);
  const bool near = std::abs(away.x) <= kOriginRange && std::abs(away.y) <= kOriginRange &&
                    std::abs(away.z) <= kOriginRange;
  if (hair.originKnown && near) return {};
  const LocalOrigin old = hair.origin;
  hair.origin = hair.origin.near(p);
  hair.bonesChanged = true;
  if (!hair.originKnown) {
    hair.originKnown = true;
    return {};
  }
  return between(old, hair.origin);
}

namespace {

void shift(ShiftedFloats& floats, std::vector<CapsuleCollider>& capsules,
           const Vector3<double>& by) {
  for (CapsuleCollider& capsule : capsules) {
    floats.shift(capsule.head, by);
    floats.shift(capsule.tail, by);
  }
}

}  // namespace

void shiftWorld(HairInternals& hair, const Vector3<double>& shift, const Vector3<double>& shifted) {
  hair.shiftedInputs.begin();
  for (AffineTransform& bone : hair.bones) hair.shiftedInputs.shift(bone, -shift);
  detail::shift(hair.shiftedInputs, hair.colliders, -shift);
  hair.shiftedInputs.end();
  shiftWorld(static_cast<HairFrameState&>(hair), shift, shifted);
}

void shiftWorld(HairFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted) {
  state.origin.shifted = shifted;
  ShiftedFloats& floats = state.shiftedFloats;
  floats.begin();
  floats.shift(state.grid.middle, -shift);
  detail::shift(floats, state.collidersBefore, -shift);
  for (AffineTransform& bone : state.bonesBefore) floats.shift(bone, -shift);
  floats.end();
  // Of outputs that are not there nothing is to be moved.
  if (state.lastFrame > 0) state.pendingShift += shift;
  state.roundedShift += std::max({std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)});
}

void forgetRounding(HairInternals& hair) {
  if (!(hair.roundedShift > 0)) return;
  constexpr double kRounding = 0x1p-23;
  const auto settle = [&](Float3& before, const Float3& now) {
    const double largest =
        static_cast<double>(std::max({std::abs(now.x), std::abs(now.y), std::abs(now.z)}));
    const double limit = kRounding * (hair.roundedShift + 2 * largest);
    const Vector3<double> moved = toDouble3(now) - toDouble3(before);
    if (std::max({std::abs(moved.x), std::abs(moved.y), std::abs(moved.z)}) <= limit) before = now;
  };
  for (size_t i = 0; i < std::min(hair.colliders.size(), hair.collidersBefore.size()); ++i) {
    settle(hair.collidersBefore[i].head, hair.colliders[i].head);
    settle(hair.collidersBefore[i].tail, hair.colliders[i].tail);
  }
  hair.roundedShift = 0;
}

bool areReplaced(std::span<const CapsuleCollider> before, std::span<const CapsuleCollider> now) {
  return !std::equal(before.begin(), before.end(), now.begin(), now.end(),
                     [](const CapsuleCollider& a, const CapsuleCollider& b) {
                       return isUsable(a) == isUsable(b) && a.headRadius == b.headRadius &&
                              a.tailRadius == b.tailRadius && a.friction == b.friction;
                     });
}

std::vector<Collider> packColliders(const HairInternals& hair, const Ball& ball, float seconds) {
  std::vector<Collider> packed;
  for (size_t i = 0; i < hair.colliders.size(); ++i) {
    const CapsuleCollider& now = hair.colliders[i];
    if (!isUsable(now)) continue;
    const bool known = i < hair.collidersBefore.size() && isUsable(hair.collidersBefore[i]);
    const CapsuleCollider& before = known ? hair.collidersBefore[i] : now;
    if (!reaches(now, ball) && !reaches(before, ball)) continue;
    const auto relative = [&](Float3 p, float w) {
      const Float3 r = hair.origin.relative(p);
      return Float4{r.x, r.y, r.z, w};
    };
    packed.push_back({.head = relative(now.head, now.headRadius),
                      .tail = relative(now.tail, now.tailRadius),
                      .headBefore = relative(before.head, now.friction),
                      .tailBefore = relative(before.tail, 0),
                      .spin = spinOf(now, seconds)});
  }
  return packed;
}

}  // namespace detail
}  // namespace pelage
