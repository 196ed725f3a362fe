// Teleports: what an object has from frame to frame moves rigidly. As with a shift of the world,
// the host moves at once, and the GPU in the list that comes next.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "scene/scene_impl.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

// Floats beyond it are not whole metres any more [m].
constexpr double kMaxDistance = 0x1p24;
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
    if (!(std::abs(shift[row]) <= kMaxDistance)) return refuse("goes farther than 16777216 m");
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

void moveCapsules(HostArray<CapsuleCollider>& capsules, const RigidMove& move) {
  for (CapsuleCollider& capsule : capsules) {
    capsule.head = toFloat3(move(toVector(capsule.head)));
    capsule.tail = toFloat3(move(toVector(capsule.tail)));
    capsule.angularVelocity = toFloat3(rotate(move.rotation, toVector(capsule.angularVelocity)));
  }
}

// What a frame goes on from. Data on the GPU are relative to the origin that it has now.
void moveState(HairFrameState& state, const RigidMove& move) {
  moveCapsules(state.collidersBefore, move);
  state.bonesBefore.clear();
  state.grid.move(move);
  state.interpolation.move(move);
  state.interpolation.forgetDrawn();
  if (!(state.solver.lastFrame() > 0)) return;
  const LocalOrigin old = state.origin;
  const Vector3<double> from = old.metres - old.shifted;
  const Vector3<double> to = move(from);
  state.origin = old.nearDouble(to);
  const RigidMove relative = {move.rotation, to - (state.origin.metres - state.origin.shifted)};
  state.teleport = state.teleport
                       ? PendingTeleport{relative.after(state.teleport->move), state.teleport->from}
                       : PendingTeleport{relative, old.metres};
  state.contacts.moveTo(state.origin);
  // What an engine rounds anew has not moved.
  for (const Vector3<double>& at : {from, to})
    state.roundedShift += std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
}

}  // namespace

Result<void> SceneImpl::teleport(HairId id, const AffineTransform& motion) {
  HairObject* object = objects_.find(id);
  if (object == nullptr) {
    return Error{ErrorCode::kInvalidArgument,
                 "teleport(): the id names no hair object of this scene"};
  }
  const Result<RigidMove> move = rigidMoveOf(motion);
  if (!move) return move.error();
  HairInternals& hair = *object->internals_;
  if (hair.skeleton == nullptr)
    for (AffineTransform& bone : hair.bones) moveBone(bone, *move);
  moveCapsules(hair.colliders, *move);
  moveGiven(hair.given, *move);
  hair.bonesChanged = true;
  moveState(hair, *move);
  // What open frames are taken back to.
  for (FrameCheckpoint& frame : frames_.open)
    for (HairCheckpoint& saved : frame.hairs)
      if (saved.object == object) moveState(saved.state, *move);
  draws_.shadows.forget();
  return {};
}

RigidMove teleportInWorld(const HairFrameState& state) {
  return teleportInWorld(state, state.origin);
}

RigidMove teleportInWorld(const HairFrameState& state, const LocalOrigin& origin) {
  const RigidMove& move = state.teleport->move;
  const Vector3<double> from = state.teleport->from - origin.shifted + state.pendingShift;
  const Vector3<double> to = origin.metres - origin.shifted;
  return {move.rotation, move.shift + to - rotate(move.rotation, from)};
}

// Moves what rooms have on the GPU but for positions.
Result<void> SceneImpl::addTeleport(const HairFrame& frame, const HairInternals& hair) {
  if (!hair.teleport) return {};
  const RigidMove world = teleportInWorld(hair);
  for (const std::vector<MovedElements>& room :
       {hair.solver.moved(frame), hair.contacts.moved(), hair.grid.moved(frame.guideVertices()),
        hair.followContacts.moved()}) {
    for (const MovedElements& elements : room) {
      const RigidMove& move = elements.inWorld ? world : hair.teleport->move;
      if (Result<void> added = addRigidMove(frame, move, elements); !added) return added;
    }
  }
  return {};
}

}  // namespace pelage::detail
