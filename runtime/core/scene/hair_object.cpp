#include "pelage/hair_object.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "contact/capsules.h"
#include "pelage/assert.h"
#include "pelage/constants.h"
#include "scene/hair_internals.h"

namespace pelage {

SimulationCounters readCounters(std::span<const std::byte> sleepWords) {
  uint32_t words[exact::kSleepSecondPasses + 1] = {};
  PELAGE_ASSERT(sleepWords.size() >= sizeof(words), "the counters are in the first 32 bytes");
  std::memcpy(words, sleepWords.data(), std::min(sleepWords.size(), sizeof(words)));
  return {.awakeStrands = words[exact::kSleepAwakeStrands],
          .secondPasses = words[exact::kSleepSecondPasses]};
}

HairObject::HairObject(std::unique_ptr<detail::HairInternals> internals)
    : internals_(std::move(internals)) {}
HairObject::~HairObject() = default;

BufferRange HairObject::rootTransforms() const {
  return internals_->get<detail::StrandSolver>().rootTransforms(buffers_);
}
uint32_t HairObject::limpGuideCount() const {
  return internals_->get<detail::StrandSolver>().limpGuides();
}
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
  HostArray<ColliderId> set(colliders.begin(), colliders.end());
  std::sort(set.begin(), set.end());
  internals_->meshColliders = std::move(set);
}

void HairObject::setForceField(const ForceField& field) { internals_->field = field; }

void HairObject::useAllMeshColliders() { internals_->meshColliders.reset(); }

void HairObject::reset() { internals_->resetPending = true; }

namespace {

bool isInRange(const Float3& p) {  // false for NaN
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate;
}

// Around points, of which there is one or more.
detail::Ball ballAround(std::span<const Float3> points) {
  Float3 low = points[0], high = low;
  for (const Float3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const float across = std::hypot(high.x - low.x, high.y - low.y, high.z - low.z);
  return {detail::middleOf({low, high}), 0.5001f * across};
}

}  // namespace

Result<void> HairObject::setPositions(std::span<const Float3> positions) {
  detail::GivenShape& given = internals_->given;
  const uint64_t wanted = uint64_t{guideCount_} * vertexCount_;
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "hair '" + name_ + "': setPositions(): " + what};
  };
  if (positions.empty()) {
    given.positions.clear();
    return {};
  }
  if (positions.size() != wanted) {
    return refuse("got " + std::to_string(positions.size()) + " positions, but " +
                  std::to_string(guideCount_) + " guides of " + std::to_string(vertexCount_) +
                  " vertices have " + std::to_string(wanted));
  }
  const auto broken = std::find_if_not(positions.begin(), positions.end(), isInRange);
  if (broken != positions.end()) {
    const auto i = static_cast<uint64_t>(broken - positions.begin());
    return refuse("vertex " + std::to_string(i % vertexCount_) + " of guide " +
                  std::to_string(i / vertexCount_) + " is not finite or beyond 1e6 m");
  }
  if (!given.isOn()) {
    // As the solvers write it: whether a vertex is free.
    given.positions.resize(positions.size());
    for (size_t i = 0; i < positions.size(); ++i) {
      const bool held = i % vertexCount_ < 2 || !(internals_->rest.asset->positions[i].w > 0);
      given.positions[i].w = held ? 0.0f : 1.0f;
    }
  }
  for (size_t i = 0; i < positions.size(); ++i) {
    const Float3& p = positions[i];
    given.positions[i] = {p.x, p.y, p.z, given.positions[i].w};
  }
  given.ball = ballAround(positions);
  ++given.version;
  return {};
}

namespace detail {
namespace {

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

}  // namespace

Ball ballOfStrands(const HairInternals& hair) {
  if (hair.given.isOn()) return hair.given.ball;
  const auto ballOf = [&](const BoneBounds& bounds) {
    const AffineTransform& bone = hair.bones[bounds.bone];
    return Ball{apply(bone, bounds.center), bounds.radius * scaleOf(bone)};
  };
  Ball all;
  const auto share = 1 / static_cast<float>(hair.bounds.size());
  for (const BoneBounds& bounds : hair.bounds) {
    const Ball ball = ballOf(bounds);
    if (!isFinite(ball.center) || !std::isfinite(ball.radius)) return {{}, INFINITY};
    all.center.x += ball.center.x * share;
    all.center.y += ball.center.y * share;
    all.center.z += ball.center.z * share;
  }
  for (const BoneBounds& bounds : hair.bounds) {
    const Ball ball = ballOf(bounds);
    all.radius = std::max(all.radius, distance(all.center, ball.center) + ball.radius);
  }
  // Blends of bones stay between what the bones do; rounding does not.
  all.radius = 1.01f * all.radius + hair.rest.longestStrand + hair.deviation;
  return all;
}

Ball ballOfCollisions(const HairInternals& hair, float tipSeparation) {
  return hair.groom.collidesFollowHairs ? ballOfHair(hair, tipSeparation) : ballOfStrands(hair);
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

void shiftWorld(HairInternals& hair, const Vector3<double>& shift, const Vector3<double>& shifted) {
  hair.shiftedInputs.begin();
  for (AffineTransform& bone : hair.bones) hair.shiftedInputs.shift(bone, -shift);
  const RigidMove move = {.rotation = {}, .shift = -shift};
  moveCapsules(hair.colliders, {.rigid = move, .shifted = &hair.shiftedInputs});
  hair.shiftedInputs.shift(hair.field.origin, -shift);
  hair.shiftedInputs.end();
  moveGiven(hair.given, move);
  shiftWorld(static_cast<HairFrameState&>(hair), shift, shifted);
}

void shiftWorld(HairFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted) {
  state.origin.shifted = shifted;
  ShiftedFloats& floats = state.shiftedFloats;
  floats.begin();
  moveRooms(state.rooms,
            {.rigid = {.rotation = {}, .shift = -shift},
             .shifted = &floats,
             .extent = std::max({std::abs(shift.x), std::abs(shift.y), std::abs(shift.z)})});
  for (AffineTransform& bone : state.bonesBefore) floats.shift(bone, -shift);
  floats.end();
  // No outputs yet: nothing to move.
  if (state.get<StrandSolver>().lastFrame() > 0) state.pendingShift += shift;
}

void moveGiven(GivenShape& given, const RigidMove& move) {
  if (!given.isOn()) return;
  for (Float4& p : given.positions) {
    const Float3 moved = toFloat3(move(toVector({p.x, p.y, p.z})));
    p = {moved.x, moved.y, moved.z, p.w};
  }
  given.ball.center = toFloat3(move(toVector(given.ball.center)));
  ++given.version;
}

}  // namespace detail
}  // namespace pelage
