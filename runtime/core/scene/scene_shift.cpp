// Shifts of the world's origin, and what lists do for teleports. Solvers' states are relative to
// origins of their own and stay as they are; the outputs, which are in world space, are written
// anew or moved by the list that comes next.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pelage/kernels.h"
#include "scene/scene_impl.h"
#include "sdf/sdf_collider.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

// Floats beyond it are not whole metres any more [m].
constexpr float kMaxShift = 0x1p24f;

bool isZero(const Vector3<double>& v) { return v.x == 0 && v.y == 0 && v.z == 0; }

// The outputs of an object are not where its state is.
bool isPending(const HairFrameState& state) {
  return state.teleport.has_value() || !isZero(state.pendingShift);
}

}  // namespace

Result<void> SceneImpl::shiftOrigin(Float3 shift) {
  for (const auto& [value, axis] :
       {std::pair(shift.x, "x"), std::pair(shift.y, "y"), std::pair(shift.z, "z")}) {
    if (std::abs(value) <= kMaxShift) continue;
    return Error{ErrorCode::kInvalidArgument, std::string("shiftOrigin(): ") + axis + " is " +
                                                  std::to_string(value) +
                                                  " m, but must be in -16777216..16777216"};
  }
  const Vector3<double> by = toVector(shift);
  shifted_ = {shifted_[0] + by.x, shifted_[1] + by.y, shifted_[2] + by.z};
  for (const auto& skeleton : skeletons_)
    if (skeleton != nullptr) shiftWorld(*skeleton->internals_, by, shifted());
  for (const auto& held : sdfs_.colliders)
    if (held != nullptr) shiftWorld(*held->internals_, by, shifted());
  for (const auto& object : objects_)
    if (object != nullptr) shiftWorld(*object->internals_, by, shifted());
  shiftFrames(by);
  draws_.shadows.forget();
  return {};
}

// What open frames are taken back to is in the new coordinates, too.
void SceneImpl::shiftFrames(const Vector3<double>& by) {
  for (FrameCheckpoint& frame : frames_.open) {
    for (HairCheckpoint& saved : frame.hairs) shiftWorld(saved.state, by, shifted());
    for (ColliderCheckpoint& saved : frame.colliders) {
      shiftWorld(saved.state, by, shifted());
      const SdfColliderInternals& now = *saved.collider->internals_;
      if (now.data || now.dense) saved.state.grid = now.grid;
    }
    for (SkeletonCheckpoint& saved : frame.skeletons) saved.origin.shifted = shifted();
  }
}

// For a list that does not simulate.
Result<void> SceneImpl::addPendingShifts(PassList& list) {
  const bool pending = std::any_of(objects_.begin(), objects_.end(), [](const auto& object) {
    return object != nullptr && isPending(*object->internals_);
  });
  if (!pending) return {};
  // Where the list does not run, the next one has to move the outputs.
  if (list.frame == 0) {
    settleFrames(false);
    saveFrame();
    frames_.recording = false;
    frames_.open.back().lastVersion = resources_.version();
    list.frame = frames_.open.back().number;
  }
  for (const auto& object : objects_) {
    if (object == nullptr || !isPending(*object->internals_)) continue;
    HairInternals& hair = *object->internals_;
    const HairFrame frame = frameOf(*object, object->settings, hair.solver.lastFrame(), 1, list);
    if (Result<void> added = addTeleport(frame, hair); !added) return added;
    if (Result<void> added = addShiftPasses(frame, hair); !added) return added;
    if (Result<void> added = hair.givenPositions.place(frame, hair.given); !added) return added;
    if (Result<void> added = addFollowShift(frame, hair); !added) return added;
    if (Result<void> added = addMotionShift(frame, hair); !added) return added;
    if (Result<void> added = addInterpolationShift(frame, hair); !added) return added;
  }
  return {};
}

// Once a list has all that addPendingShifts() or simulateObject() adds.
void SceneImpl::finishShift() {
  for (const auto& object : objects_) {
    if (object == nullptr || !isPending(*object->internals_)) continue;
    object->internals_->pendingShift = {};
    object->internals_->teleport.reset();
    object->internals_->contacts.shiftWorld(shifted());
  }
}

// The guides, and what the next sub-step goes on from.
Result<void> SceneImpl::addShiftPasses(const HairFrame& frame, HairInternals& hair) {
  if (!isPending(hair)) return {};
  if (Result<void> rewritten = hair.solver.rewritePositions(frame); !rewritten) return rewritten;
  if (hair.storesFollowHairs) hair.solver.placeFollowsAnew();
  if (hair.teleport) return {};
  const Float3 by = toFloat3(-hair.pendingShift);
  const HairContacts& contacts = hair.contacts;
  if (contacts.before() != BufferId::kInvalid) {
    Result<void> added =
        addShift(frame, by, contacts.before(), contacts.beforeElement(), contacts.vertexCount());
    if (!added) return added;
  }
  if (hair.grid.before() != BufferId::kInvalid) {
    Result<void> added = addShift(frame, by, hair.grid.before(), 0, frame.guideVertices());
    if (!added) return added;
  }
  if (!hair.followContacts.goesOn()) return {};
  return addShift(frame, by, hair.followContacts.before(), 0, hair.followContacts.beforeCount());
}

// Stored follow hairs, which a simulation places anew in any case.
Result<void> SceneImpl::addFollowShift(const HairFrame& frame, const HairInternals& hair) {
  if (!hair.storesFollowHairs) return {};
  if (!hair.followContacts.goesOn()) return addFollowPass(frame);
  const uint64_t first = frame.guideVertices();
  const uint64_t count = uint64_t{frame.followCount} * frame.vertexCount;
  const BufferId positions = frame.buffers.positions;
  if (hair.teleport) {
    return addRigidMove(frame, teleportInWorld(hair),
                        {positions, first, count, 1, {move_rigidly::kMovesPoint}});
  }
  return addShift(frame, toFloat3(-hair.pendingShift), positions, first, count);
}

// Positions of the last frame that draws of this frame take.
Result<void> SceneImpl::addMotionShift(const HairFrame& frame, const HairInternals& hair) const {
  const BufferId before = hair.motion.before(draws_.frame).positions;
  if (before == BufferId::kInvalid) return {};
  const uint64_t count = motionHairOf(frame, hair, 0).elements;
  if (hair.teleport) {
    return addRigidMove(frame, teleportInWorld(hair),
                        {before, 0, count, 1, {move_rigidly::kMovesPoint}});
  }
  return addShift(frame, toFloat3(-hair.pendingShift), before, 0, count);
}

}  // namespace pelage::detail
