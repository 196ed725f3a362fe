// What was before a frame: kept by the frames that simulate, for motion vectors; and for frames
// that draw between the last two states.
#include <algorithm>
#include <string>

#include "scene/scene_impl.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

InterpolatedHair SceneImpl::interpolatedHairOf(const HairFrame& frame, const HairInternals& hair,
                                               const MotionHair& positions) {
  return {.positions = positions,
          .vertices = frame.vertexCount,
          .guides = frame.guideCount,
          .roots = frame.roots,
          .evaluatesFollows = frame.followCount > 0 && !hair.storesFollowHairs};
}

// Makes the buffers that are wanted, and removes the others.
void SceneImpl::prepareBefore(const HairObject& object, HairFrame& frame,
                              const MotionHair& motion) {
  HairInternals& hair = *object.internals_;
  hair.motion.prepare(motion, object.tracksMotion, frame.room);
  hair.interpolation.prepare(interpolatedHairOf(frame, hair, motion), object.interpolates,
                             frame.room);
  const StrandsBetween between = hair.interpolation.buffers();
  frame.buffers.previousPositions = hair.motion.positions();
  frame.buffers.drawnPositions = between.positions;
  frame.buffers.drawnTangents = between.tangents;
  frame.buffers.drawnRoots = between.roots;
}

// Before anything moves the strands. With interpolation, motion is that between frames that draw.
Result<void> SceneImpl::keepBefore(HairInternals& hair, const HairFrame& frame,
                                   const MotionHair& motion, uint64_t placed) {
  if (!hair.interpolation.isOn())
    return startsStill(frame, hair) ? Result<void>() : hair.motion.keep(motion, frame.list);
  if (frame.reset) return {};
  if (!hair.teleport) return hair.interpolation.keep(motion, frame.list);
  MotionHair unmoved = motion;
  unmoved.movedFrom = ~uint64_t{0};
  Result<void> kept = hair.interpolation.keep(unmoved, frame.list);
  if (!kept || placed >= motion.elements) return kept;
  return addRigidMove(frame, teleportInWorld(hair, frame.stateOrigin),
                      {hair.interpolation.before(),
                       placed,
                       motion.elements - placed,
                       1,
                       {move_rigidly::kMovesPoint}});
}

// Behind what has moved the strands: a reset has no state before.
Result<void> SceneImpl::keepBehind(const HairObject& object, const HairFrame& frame,
                                   const MotionHair& motion) const {
  HairInternals& hair = *object.internals_;
  if (!hair.interpolation.isOn()) {
    const bool still = startsStill(frame, hair);
    hair.motion.finish(motion, still, draws_.frame);
    return still ? hair.motion.keep(motion, frame.list) : Result<void>();
  }
  hair.interpolation.finishState(frame.reset, ballOfHair(hair, object.settings.tipSeparation));
  return frame.reset ? hair.interpolation.keep(motion, frame.list) : Result<void>();
}

Result<void> SceneImpl::interpolate(float share, PassList& list) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "interpolate(): " + what};
  };
  // Also for NaN.
  if (!(share >= 0 && share <= 1))
    return refuse("the share is " + std::to_string(share) + ", but must be in 0..1");
  const auto concerns = [](const auto& object) {
    return object != nullptr && (object->interpolates || object->internals_->interpolation.isOn());
  };
  if (std::none_of(objects_.begin(), objects_.end(), concerns)) return {};
  settleFrames(false);
  if (list.frame != 0 && (frames_.open.empty() || frames_.open.back().number != list.frame))
    return refuse("the list is that of an earlier frame: take the one of the last simulate()");
  if (Result<void> moved = addPendingShifts(list); !moved) return moved;
  finishShift();
  if (list.frame == 0) {
    saveFrame();
    list.frame = frames_.open.back().number;
  }
  frames_.recording = true;
  Result<void> done;
  for (const auto& object : objects_) {
    if (!concerns(object)) continue;
    done = interpolateObject(*object, share, list);
    if (!done) break;
  }
  frames_.recording = false;
  frames_.open.back().lastVersion = resources_.version();
  if (done) return done;
  list.clear();
  restoreFrame();
  return done;
}

Result<void> SceneImpl::interpolateObject(HairObject& object, float share, PassList& list) {
  HairInternals& hair = *object.internals_;
  HairFrame frame = frameOf(object, object.settings, hair.solver.lastFrame(), 1, list);
  const MotionHair now = motionHairOf(frame, hair, 0);
  prepareBefore(object, frame, now);
  if (!hair.interpolation.isOn()) return {};
  const bool restarts = hair.resetPending || !hair.interpolation.hasDrawn();
  const bool known = !hair.resetPending && hair.interpolation.knowsState();
  MotionHair drawn = now;
  drawn.positions = hair.interpolation.buffers().positions;
  if (!restarts) {
    if (Result<void> kept = hair.motion.keep(drawn, list); !kept) return kept;
  }
  const InterpolatedHair between = interpolatedHairOf(frame, hair, now);
  Result<void> placed = hair.interpolation.record(between, share, known, restarts, list);
  if (!placed) return placed;
  hair.interpolation.finish(draws_.frame);
  hair.motion.finish(drawn, restarts, draws_.frame);
  return restarts ? hair.motion.keep(drawn, list) : Result<void>();
}

// The state before, and what was drawn last.
Result<void> SceneImpl::addInterpolationShift(const HairFrame& frame, const HairInternals& hair) {
  const StrandInterpolation& between = hair.interpolation;
  if (!between.isOn()) return {};
  const uint64_t count = motionHairOf(frame, hair, 0).elements;
  if (hair.teleport) {
    return addRigidMove(frame, teleportInWorld(hair),
                        {between.before(), 0, count, 1, {move_rigidly::kMovesPoint}});
  }
  const Float3 by = toFloat3(-hair.pendingShift);
  if (between.knowsState()) {
    Result<void> added = addShift(frame, by, between.before(), 0, count);
    if (!added) return added;
  }
  if (!between.hasDrawn()) return {};
  return addShift(frame, by, between.buffers().positions, 0, count);
}

}  // namespace pelage::detail
