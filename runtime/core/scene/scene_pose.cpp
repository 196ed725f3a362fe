// Hair that no solver moves. In frames of 0 s hair that has not moved yet is shown in its bind pose
// under the bones, and its reset waits for the first frame that moves it; hair that is not
// simulated has this pose in every frame.
#include <algorithm>
#include <string>
#include <utility>

#include "scene/scene_impl.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

// A reset of the solvers is the bind pose where nothing acts on it.
SimulationSettings withoutForces(SimulationSettings settings) {
  settings.gravity = {};
  settings.wind.velocity = {};
  settings.contact = {};
  settings.sleep.enabled = false;
  settings.subSteps = 1;
  return settings;
}

constexpr float kPoseStep = 1.0f / 60;  // [s]; the pose does not depend on it

}  // namespace

Result<void> SceneImpl::poseNewHair(PassList& list) {
  const auto isNew = [](const auto& object) {
    return object != nullptr && object->internals_->resetPending;
  };
  if (std::none_of(objects_.begin(), objects_.end(), isNew)) return {};
  if (Result<void> valid = checkSkeletons(); !valid) return valid;
  for (const auto& object : objects_) {
    if (!isNew(object)) continue;
    if (Result<void> valid = checkObject(*object); !valid)
      return Error{valid.error().code, "hair '" + object->name_ + "': " + valid.error().message};
  }
  if (list.frame == 0) {
    saveFrame();
    list.frame = frames_.open.back().number;
  }
  frames_.recording = true;
  followSkeletons();
  Result<void> done;
  for (const auto& object : objects_) {
    if (!isNew(object)) continue;
    done = poseObject(*object, list);
    if (!done) break;
  }
  frames_.recording = false;
  frames_.open.back().lastVersion = resources_.version();
  if (!done) restoreFrame();
  return done;
}

Result<void> SceneImpl::poseObject(HairObject& object, PassList& list) {
  HairInternals& hair = *object.internals_;
  const SimulationSettings settings = withoutForces(object.settings);
  HairFrame frame = frameOf(object, settings, kPoseStep, 1, list);
  hair.solver.prepare(frame);
  hair.givenPositions.prepare(frame, hair.given);
  const HairFrameState before = hair;
  hair.grid.pause();
  sendAgain(hair);
  frame.reset = true;
  frame.rebase = moveOrigin(hair);
  frame.origin = hair.origin;
  Result<void> added = sendBones(object, list);
  if (added) added = addRootPass(frame, hair.skinning);
  if (added) {
    added = isSimulated(object) ? hair.solver.record(frame, hair.grid, gridHairOf(frame, hair))
                                : hair.solver.skin(frame);
  }
  if (added) added = hair.givenPositions.place(frame, hair.given);
  if (added) added = addFollowPass(frame);
  static_cast<HairFrameState&>(hair) = before;
  hair.resetPending = hair.bonesChanged = true;
  return added;
}

bool SceneImpl::isSimulated(const HairObject& object) {
  return object.simulated && !object.internals_->given.isOn();
}

// HairObject::simulated is false: nothing but the bones, or what is given, moves the hair.
Result<void> SceneImpl::skinObject(HairObject& object, HairFrame& frame) {
  HairInternals& hair = *object.internals_;
  hair.grid.prepare(gridHairOf(frame, hair), false, frame.room);
  frame.buffers.contactForces = hair.grid.forces();
  if (Result<void> sent = beginBones(object, frame); !sent) return sent;
  // What collides again later has no history, and capsules have not moved meanwhile.
  hair.contacts.forget();
  hair.contacts.clearTotals(frame.list);
  hair.followContacts.forget();
  hair.collidersBefore = hair.colliders;
  hair.roundedShift = 0;
  const MotionHair motion = motionHairOf(frame, hair, 0);
  prepareBefore(object, frame, motion);
  if (Result<void> kept = keepBefore(hair, frame, motion, 0); !kept) return kept;
  const Vector3<double>& shift = hair.pendingShift;
  const bool shifts = shift.x != 0 || shift.y != 0 || shift.z != 0;
  const bool posed = std::exchange(hair.skinned, true) && hair.stillFrames >= 2 && !shifts;
  Result<void> added;
  if (hair.stillFrames < 2) added = addRootPass(frame, hair.skinning);
  // What is given takes a state once, for what else moves with it.
  const bool given = hair.given.isOn();
  if (added && !posed && (!given || frame.reset)) added = hair.solver.skin(frame);
  if (added && given && (frame.reset || !hair.givenPositions.has(hair.given)))
    added = hair.givenPositions.place(frame, hair.given);
  hair.resetPending = false;
  if (added) added = addFollowPass(frame);
  return added ? keepBehind(object, frame, motion) : added;
}

}  // namespace pelage::detail
