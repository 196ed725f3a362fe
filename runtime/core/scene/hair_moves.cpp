// Shifts of the world's origin, and teleports: the host moves at once, and the GPU in the list that
// comes next. Solvers' states are relative to origins of their own and stay as they are at shifts;
// the outputs, which are in world space, are written anew or moved.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "contact/capsules.h"
#include "scene/scene_parts.h"

namespace pelage {
namespace detail {

namespace {

// Floats beyond it are not whole meters any more [m].
constexpr double kMaxMove = 0x1p24;
// How far the rows of a rotation may be off unit length and right angles.
constexpr double kRotationError = 1e-3;

// The quaternion of a rotation matrix, by its largest component (Shepperd 1978).
UnitQuaternion<double> quaternionOf(const std::array<Vector3<double>, 3>& m) {
  const double xx = m[0].x, yy = m[1].y, zz = m[2].z;
  const std::array<double, 4> sizes = {xx - yy - zz, yy - xx - zz, zz - xx - yy, xx + yy + zz};
  switch (std::max_element(sizes.begin(), sizes.end()) - sizes.begin()) {
    case 0:
      return normalized(
          UnitQuaternion<double>{1 + sizes[0], m[1].x + m[0].y, m[0].z + m[2].x, m[2].y - m[1].z});
    case 1:
      return normalized(
          UnitQuaternion<double>{m[1].x + m[0].y, 1 + sizes[1], m[2].y + m[1].z, m[0].z - m[2].x});
    case 2:
      return normalized(
          UnitQuaternion<double>{m[0].z + m[2].x, m[2].y + m[1].z, 1 + sizes[2], m[1].x - m[0].y});
    default:
      return normalized(
          UnitQuaternion<double>{m[2].y - m[1].z, m[0].z - m[2].x, m[1].x - m[0].y, 1 + sizes[3]});
  }
}

Result<RigidMove> rigidMoveOf(const AffineTransform& motion) {
  const auto refuse = [](const char* what) {
    return Error{ErrorCode::kInvalidArgument, std::string("teleport(): the motion ") + what};
  };
  std::array<Vector3<double>, 3> rows;
  std::array<double, 3> shift = {};
  for (size_t row = 0; row < 3; ++row) {
    const Float4& r = motion.rows[row];
    rows[row] = toVector({r.x, r.y, r.z});
    shift[row] = static_cast<double>(r.w);
    // Also for NaN.
    if (!(std::abs(shift[row]) <= kMaxMove)) return refuse("goes farther than 16777216 m");
  }
  for (size_t a = 0; a < 3; ++a) {
    for (size_t b = 0; b <= a; ++b) {
      const double off = dot(rows[a], rows[b]) - (a == b ? 1 : 0);
      if (!(std::abs(off) <= kRotationError)) return refuse("is not rigid: it scales or shears");
    }
  }
  if (!(dot(cross(rows[0], rows[1]), rows[2]) > 0)) return refuse("is not rigid: it mirrors");
  return RigidMove{quaternionOf(rows), {shift[0], shift[1], shift[2]}};
}

void moveBone(AffineTransform& bone, const RigidMove& move) {
  const auto column = [&](auto member) {
    return Vector3<double>{static_cast<double>(bone.rows[0].*member),
                           static_cast<double>(bone.rows[1].*member),
                           static_cast<double>(bone.rows[2].*member)};
  };
  const auto set = [&](auto member, const Vector3<double>& v) {
    const Float3 narrow = toFloat3(v);
    bone.rows[0].*member = narrow.x;
    bone.rows[1].*member = narrow.y;
    bone.rows[2].*member = narrow.z;
  };
  for (const auto member : {&Float4::x, &Float4::y, &Float4::z})
    set(member, rotate(move.rotation, column(member)));
  set(&Float4::w, move(column(&Float4::w)));
}

// Data on the GPU stay relative to the origin that the state has now.
void moveState(HairFrameState& state, const RigidMove& move) {
  state.bonesBefore.clear();
  WorldMove world = {.rigid = move};
  if (state.get<StrandSolver>().lastFrame() > 0) {
    const LocalOrigin old = state.origin;
    const Vector3<double> from = old.metres - old.shifted;
    const Vector3<double> to = move(from);
    state.origin = old.nearDouble(to);
    const RigidMove relative = {move.rotation, to - (state.origin.metres - state.origin.shifted)};
    state.teleport =
        state.teleport ? PendingTeleport{relative.after(state.teleport->move), state.teleport->from}
                       : PendingTeleport{relative, old.metres};
    world.origin = state.origin;
    for (const Vector3<double>& at : {from, to})
      world.extent += std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  }
  moveRooms(state.rooms, world);
}

}  // namespace

RigidMove teleportInWorld(const HairFrameState& state) {
  return teleportInWorld(state, state.origin);
}

RigidMove teleportInWorld(const HairFrameState& state, const LocalOrigin& origin) {
  const RigidMove& move = state.teleport->move;
  const Vector3<double> from = state.teleport->from - origin.shifted + state.pendingShift;
  const Vector3<double> to = origin.metres - origin.shifted;
  return {move.rotation, move.shift + to - rotate(move.rotation, from)};
}

}  // namespace detail

Result<void> Scene::shiftOrigin(Float3 shift) {
  for (const auto& [value, axis] :
       {std::pair(shift.x, "x"), std::pair(shift.y, "y"), std::pair(shift.z, "z")}) {
    if (std::abs(static_cast<double>(value)) <= detail::kMaxMove) continue;
    return Error{ErrorCode::kInvalidArgument, std::string("shiftOrigin(): ") + axis + " is " +
                                                  std::to_string(value) +
                                                  " m, but must be in -16777216..16777216"};
  }
  detail::HairStore& store = parts_->store;
  const detail::Vector3<double> by = detail::toVector(shift);
  store.shifted += by;
  for (SkeletonPose& skeleton : store.skeletons())
    shiftWorld(detail::HairStore::of(skeleton), by, store.shifted);
  for (SdfCollider& held : store.colliders())
    shiftWorld(detail::HairStore::of(held), by, store.shifted);
  for (HairObject& object : store.hairs())
    shiftWorld(detail::HairStore::of(object), by, store.shifted);
  // Open frames go back to the new coordinates, too.
  for (detail::FrameCheckpoint& frame : parts_->journal.open()) {
    for (detail::HairCheckpoint& saved : frame.hairs) shiftWorld(saved.state, by, store.shifted);
    for (detail::ColliderCheckpoint& saved : frame.colliders) {
      shiftWorld(saved.state, by, store.shifted);
      const detail::SdfColliderInternals& now = detail::HairStore::of(*saved.collider);
      if (now.data || now.dense) saved.state.grid = now.grid;
    }
    for (detail::SkeletonCheckpoint& saved : frame.skeletons) saved.origin.shifted = store.shifted;
  }
  parts_->drawing.shadows.forget();
  return {};
}

Result<void> Scene::teleport(HairId id, const AffineTransform& motion) {
  HairObject* object = parts_->store.hairSlots.find(id);
  if (object == nullptr) {
    return Error{ErrorCode::kInvalidArgument,
                 "teleport(): the id names no hair object of this scene"};
  }
  const Result<detail::RigidMove> move = detail::rigidMoveOf(motion);
  if (!move) return move.error();
  detail::HairInternals& hair = detail::HairStore::of(*object);
  if (hair.skeleton == nullptr)
    for (AffineTransform& bone : hair.bones) detail::moveBone(bone, *move);
  detail::moveCapsules(hair.colliders, {.rigid = *move});
  moveGiven(hair.given, *move);
  hair.bonesChanged = true;
  detail::moveState(hair, *move);
  // Open frames go back to the new place.
  for (detail::FrameCheckpoint& frame : parts_->journal.open())
    for (detail::HairCheckpoint& saved : frame.hairs)
      if (saved.object == object) detail::moveState(saved.state, *move);
  parts_->drawing.shadows.forget();
  return {};
}

}  // namespace pelage
