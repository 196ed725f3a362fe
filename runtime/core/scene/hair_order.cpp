#include "scene/hair_order.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

/// An object whose passes are recorded.
struct HairWork {
  HairStore& store;
  HairObject& object;
  HairInternals& hair;
  HairFrame frame;
  float share;                           ///< FrameTime::share
  std::optional<HairFrameState> before;  ///< that a pose goes back to
};

// A reset of the solvers is the bind pose where nothing acts on it.
SimulationSettings withoutForces(SimulationSettings settings) {
  settings.gravity = {};
  settings.wind.velocity = {};
  settings.contact = {};
  settings.sleep.enabled = false;
  settings.subSteps = 1;
  return settings;
}

// \param moved  elements, from the first, that are already where shifts of the world bring them
MotionHair motionHairOf(const HairWork& work, uint64_t moved = 0) {
  const HairFrame& frame = work.frame;
  MotionHair motion = {.name = frame.name,
                       .positions = frame.buffers.positions,
                       .elements = frame.storedVertices(),
                       .tipSeparation = frame.settings.tipSeparation};
  const Float3 shift = toFloat3(-work.hair.pendingShift);
  if (!frame.reset && !isZero(shift)) {
    motion.movedFrom = moved;
    motion.move = shift;
  }
  return motion;
}

// Shifts and teleports have moved the guides of simulated hair before its positions are kept.
uint64_t movedElements(const HairFrame& frame) {
  return frame.mode == FrameMode::kSimulate ? frame.guideVertices() : 0;
}

// Share of gravity, wind and forces since the object is simulated again.
float blendOf(const HairObject& object, HairInternals& hair, float dt) {
  if (std::exchange(hair.skinned, false)) hair.sinceSkinned = 0;
  const float since = hair.sinceSkinned;
  hair.sinceSkinned += dt;
  return since < object.blendTime ? since / object.blendTime : 1.0f;
}

// The object counts as not having moved: after resets and teleports.
bool startsStill(const HairWork& work) {
  return work.frame.reset || work.hair.teleport.has_value();
}

// The stages of a frame: frameOrder() says which modes have them.

Result<void> prepare(HairWork& work) {
  HairInternals& hair = work.hair;
  HairFrame& frame = work.frame;
  frame.reset = hair.resetPending;
  prepareRooms(hair.rooms, frame);
  hair.resetPending = frame.reset;
  if (frame.mode == FrameMode::kPose) {
    work.before = hair;
    sendAgain(hair);
    frame.reset = true;
    return {};
  }
  if (frame.otherRest) hair.bonesChanged = true;  // the roots are elsewhere
  if (frame.mode == FrameMode::kSkin) return {};
  frame.loadShare *= blendOf(work.object, hair, frame.length);
  frame.air = airAt(frame.settings.wind, work.store.time, frame.loadShare);
  return {};
}

// Moves the rooms' data on the GPU, but no positions.
Result<void> teleportStates(HairWork& work) {
  const HairInternals& hair = work.hair;
  if (!hair.teleport || work.frame.reset) return {};
  const RigidMove world = teleportInWorld(hair);
  return addMoves(hair.rooms, work.frame, [&](const MovedElements& elements) {
    return addRigidMove(work.frame, elements.inWorld ? world : hair.teleport->move, elements);
  });
}

Result<void> placeBones(HairWork& work) {
  HairInternals& hair = work.hair;
  HairFrame& frame = work.frame;
  frame.rebase = moveOrigin(hair);
  frame.origin = hair.origin;
  hair.stillFrames = hair.bonesChanged || frame.reset ? 0 : hair.stillFrames + 1;
  if (!std::exchange(hair.bonesChanged, false)) return {};
  if (hair.skeleton != nullptr) {
    const Result<void> sent =
        sendBones(*hair.skeleton, hair.skinning, work.store.resources, frame.list);
    if (!sent) return sent;
  } else {
    sendBones(hair.bones, hair.origin, hair.skinning, frame.buffers.boneTransforms, frame.list);
  }
  hair.bonesBefore = hair.bones;
  return {};
}

Result<void> sendColliders(HairWork& work) {
  const HairFrame& frame = work.frame;
  work.hair.get<HairColliders>().record(work.frame, work.store.sdfs,
                                        ballOfCollisions(work.hair, frame.settings.tipSeparation),
                                        [&frame] { return StrandSolver::strandsOf(frame); });
  return {};
}

Result<void> pause(HairWork& work) {
  pauseRooms(work.hair.rooms, work.frame);
  return {};
}

// The guides, and what the next sub-step goes on from. A reset writes all of it.
Result<void> shiftStates(HairWork& work) {
  HairInternals& hair = work.hair;
  const HairFrame& frame = work.frame;
  if (frame.reset || !isMovePending(hair)) return {};
  StrandSolver& solver = hair.get<StrandSolver>();
  if (Result<void> rewritten = solver.rewritePositions(frame); !rewritten) return rewritten;
  if (hair.groom.storesFollowHairs) solver.placeFollowsAnew();
  if (hair.teleport) return {};
  const Float3 by = toFloat3(-hair.pendingShift);
  return addMoves(hair.rooms, frame, [&](const MovedElements& elements) {
    if (!elements.inWorld) return Result<void>();
    return addShift(frame, by, elements.buffer, elements.first, elements.count);
  });
}

// Before anything moves the strands. With interpolation, motion is that between frames that draw.
Result<void> keepBefore(HairWork& work) {
  const HairInternals& hair = work.hair;
  const HairFrame& frame = work.frame;
  const StrandInterpolation& between = hair.get<StrandInterpolation>();
  const uint64_t moved = movedElements(frame);
  const MotionHair motion = motionHairOf(work, moved);
  if (!between.isOn()) {
    return startsStill(work) ? Result<void>() : hair.get<StrandMotion>().keep(motion, frame.list);
  }
  if (frame.reset) return {};
  if (!hair.teleport) return between.keep(motion, frame.list);
  MotionHair unmoved = motion;
  unmoved.movedFrom = ~uint64_t{0};
  Result<void> kept = between.keep(unmoved, frame.list);
  if (!kept || moved >= motion.elements) return kept;
  return addRigidMove(
      frame, teleportInWorld(hair, frame.stateOrigin),
      {between.before(), moved, motion.elements - moved, 1, {move_rigidly::kMovesPoint}});
}

// After two frames with the same bones both sets of transforms are the same.
Result<void> placeRoots(HairWork& work) {
  return work.hair.stillFrames < 2 ? addRootPass(work.frame, work.hair.skinning) : Result<void>();
}

template <class Room>
Result<void> record(HairWork& work) {
  return work.hair.get<Room>().record(work.frame);
}

Result<void> simulateGuides(HairWork& work) {
  const bool poses = work.frame.mode == FrameMode::kPose;
  // Functions of one pointer, which need no memory.
  const StepInputs inputs = {.beginStep = [&work](double h, bool reset) -> Result<void> {
                               if (work.frame.mode == FrameMode::kPose) return {};
                               return work.hair.get<HairGrid>().record(work.frame, h, reset);
                             },
                             .findContacts =
                                 [&work](const ContactPart& part) {
                                   return work.hair.get<HairColliders>().find(work.frame, part);
                                 }};
  Result<void> added = work.hair.get<StrandSolver>().record(work.frame, inputs);
  if (added && !poses) work.hair.get<HairGrid>().finish(work.frame);
  return added;
}

Result<void> moveGuides(HairWork& work) {
  HairInternals& hair = work.hair;
  StrandSolver& solver = hair.get<StrandSolver>();
  if (work.frame.mode == FrameMode::kPose)
    return isSimulated(work.object) ? simulateGuides(work) : solver.skin(work.frame);
  hair.resetPending = false;
  if (work.frame.mode == FrameMode::kSimulate) return simulateGuides(work);
  const Vector3<double>& shift = hair.pendingShift;
  const bool posed = std::exchange(hair.skinned, true) && hair.stillFrames >= 2 && shift.x == 0 &&
                     shift.y == 0 && shift.z == 0;
  // Given positions initialize the solver's state once.
  const bool wanted = !posed && (!hair.given.isOn() || work.frame.reset);
  return wanted ? solver.skin(work.frame) : Result<void>();
}

// Stored follow hairs; where they have collided, a list that only moves hair moves them with it.
Result<void> placeFollows(HairWork& work) {
  const bool stay = work.frame.mode == FrameMode::kMove && work.hair.get<FollowContacts>().goesOn();
  return stay ? Result<void>() : addFollowPass(work.frame);
}

Result<void> collideFollows(HairWork& work) {
  return work.hair.get<FollowContacts>().record(work.frame,
                                                work.hair.get<HairColliders>().inReach());
}

// Moves the data that draws read.
Result<void> moveOutputs(HairWork& work) {
  const HairInternals& hair = work.hair;
  const HairFrame& frame = work.frame;
  const uint64_t guides = frame.guideVertices(), count = frame.storedVertices();
  const auto move = [&](BufferId buffer, uint64_t first, uint64_t elements) {
    if (hair.teleport)
      return addRigidMove(frame, teleportInWorld(hair),
                          {buffer, first, elements, 1, {move_rigidly::kMovesPoint}});
    return addShift(frame, toFloat3(-hair.pendingShift), buffer, first, elements);
  };
  Result<void> moved;
  if (hair.groom.storesFollowHairs && hair.get<FollowContacts>().goesOn())
    moved = move(frame.buffers.positions, guides, count - guides);
  const BufferId before = hair.get<StrandMotion>().before(work.store.frame).positions;
  if (moved && before != BufferId::kInvalid) moved = move(before, 0, count);
  const StrandInterpolation& between = hair.get<StrandInterpolation>();
  if (!between.isOn()) return moved;
  if (moved && (hair.teleport || between.knowsState())) moved = move(between.before(), 0, count);
  if (moved && !hair.teleport && between.hasDrawn())
    moved = move(between.buffers().positions, 0, count);
  return moved;
}

// Behind what has moved the strands: a reset has no state before.
Result<void> keepAfter(HairWork& work) {
  HairInternals& hair = work.hair;
  const HairFrame& frame = work.frame;
  const MotionHair now = motionHairOf(work, movedElements(frame));
  StrandInterpolation& between = hair.get<StrandInterpolation>();
  if (!between.isOn()) {
    const bool still = startsStill(work);
    hair.get<StrandMotion>().finish(now, still, work.store.frame);
    return still ? hair.get<StrandMotion>().keep(now, frame.list) : Result<void>();
  }
  between.finishState(frame.reset, ballOfHair(hair, frame.settings.tipSeparation));
  return frame.reset ? between.keep(now, frame.list) : Result<void>();
}

// Between the last two states.
Result<void> placeBetween(HairWork& work) {
  HairFrame& frame = work.frame;
  StrandMotion& motion = work.hair.get<StrandMotion>();
  StrandInterpolation& between = work.hair.get<StrandInterpolation>();
  motion.prepare(frame);
  between.prepare(frame);
  if (!between.isOn()) return {};
  const bool reset = work.hair.resetPending;
  const bool restarts = reset || !between.hasDrawn();
  const bool known = !reset && between.knowsState();
  const MotionHair now = motionHairOf(work);
  MotionHair drawn = now;
  drawn.positions = between.buffers().positions;
  if (!restarts) {
    if (Result<void> kept = motion.keep(drawn, frame.list); !kept) return kept;
  }
  const InterpolatedHair states = {.positions = now,
                                   .vertices = frame.vertexCount,
                                   .guides = frame.guideCount,
                                   .roots = frame.roots};
  Result<void> placed = between.record(states, work.share, known, restarts, frame.list);
  if (!placed) return placed;
  between.finish(work.store.frame);
  motion.finish(drawn, restarts, work.store.frame);
  return restarts ? motion.keep(drawn, frame.list) : Result<void>();
}

/// A part of a frame, and the modes that have it.
struct Stage {
  uint32_t modes;
  Result<void> (*record)(HairWork&);
};

template <class... Modes>
constexpr uint32_t in(Modes... modes) {
  return (static_cast<uint32_t>(modes) | ...);
}

std::span<const Stage> frameOrder() {
  using enum FrameMode;
  static constexpr std::array kOrder = {
      Stage{in(kSimulate, kSkin, kPose), prepare},
      Stage{in(kSimulate, kSkin, kMove), teleportStates},
      Stage{in(kSimulate, kSkin, kPose), placeBones},
      Stage{in(kSimulate), sendColliders},
      Stage{in(kSkin), pause},
      Stage{in(kSimulate, kMove), shiftStates},
      Stage{in(kSimulate, kSkin), keepBefore},
      Stage{in(kSimulate, kSkin, kPose), placeRoots},
      Stage{in(kSimulate), record<FieldForces>},
      Stage{in(kSimulate, kSkin, kPose), moveGuides},
      Stage{in(kSkin, kPose, kMove), record<GivenPositions>},
      Stage{in(kSimulate, kSkin, kPose, kMove), placeFollows},
      Stage{in(kSimulate), collideFollows},
      Stage{in(kMove), moveOutputs},
      Stage{in(kSimulate, kSkin), keepAfter},
      Stage{in(kBetween), placeBetween},
  };
  return kOrder;
}

}  // namespace

bool isSimulated(const HairObject& object) {
  return object.simulated && !HairStore::of(object).given.isOn();
}

std::optional<HairReach> reachOf(const HairObject& object) {
  if (!object.usesMeshColliders || !isSimulated(object)) return std::nullopt;
  const HairInternals& hair = HairStore::of(object);
  return HairReach{ballOfCollisions(hair, object.settings.tipSeparation),
                   hair.meshColliders ? &*hair.meshColliders : nullptr};
}

bool isMovePending(const HairFrameState& state) {
  const Vector3<double>& shift = state.pendingShift;
  return state.teleport.has_value() || shift.x != 0 || shift.y != 0 || shift.z != 0;
}

namespace {

// More where colliders are fast. Moves of hair and world count as none.
uint32_t subStepsOf(const HairStore& store, const HairObject& object, FrameMode mode,
                    FrameTime time) {
  const HairInternals& hair = HairStore::of(object);
  const SimulationSettings& settings = object.settings;
  if (mode != FrameMode::kSimulate || settings.solver != Solver::kExact || hair.resetPending ||
      isMovePending(hair))
    return settings.subSteps;
  return hair.get<HairColliders>().subSteps(
      hair, hair.bonesBefore, settings, ballOfCollisions(hair, settings.tipSeparation),
      object.usesMeshColliders ? &store.sdfs : nullptr, time.steps);
}

}  // namespace

HairFrame frameOf(HairStore& store, HairObject& object, const SimulationSettings& settings,
                  FrameMode mode, FrameTime time, PassList& list) {
  HairInternals& hair = HairStore::of(object);
  const bool continues = mode == FrameMode::kMove || mode == FrameMode::kBetween;
  const HairBuffers& buffers = object.buffers();
  return {.name = object.name(),
          .groom = hair.groom,
          .inputs = hair,
          .settings = settings,
          .buffers = HairStore::buffersOf(object),
          .factory = store.factory(&object),
          .list = list,
          .mode = mode,
          .guideCount = object.guideCount(),
          .followCount = object.followCount(),
          .vertexCount = object.verticesPerStrand(),
          .boneCount = object.boneCount(),
          .simulatedShare = object.simulatedShare,
          .usesMeshColliders = object.usesMeshColliders,
          .tracksMotion = object.tracksMotion,
          .interpolates = object.interpolates,
          .length = continues ? hair.get<StrandSolver>().lastFrame() : time.dt,
          .steps = time.steps,
          .air = {},
          .loadShare = loadShareOf(settings),
          .reset = false,
          .stateOrigin = hair.origin,
          .origin = hair.origin,
          .rebase = {},
          .roots = object.rootTransforms(),
          .forces = mode == FrameMode::kSimulate ? buffers.forces : BufferId::kInvalid};
}

Result<void> recordHair(HairStore& store, HairObject& object, FrameMode mode, FrameTime time,
                        PassList& list) {
  HairInternals& hair = HairStore::of(object);
  ++store.moves;
  std::optional<SimulationSettings> changed;
  if (mode == FrameMode::kPose) changed = withoutForces(object.settings);
  if (const uint32_t subSteps = subStepsOf(store, object, mode, time);
      subSteps != object.settings.subSteps) {
    changed = object.settings;
    changed->subSteps = subSteps;
  }
  const SimulationSettings& settings = changed ? *changed : object.settings;
  HairWork work = {.store = store,
                   .object = object,
                   .hair = hair,
                   .frame = frameOf(store, object, settings, mode, time, list),
                   .share = time.share,
                   .before = std::nullopt};
  work.frame.hasFastColliders = settings.subSteps > object.settings.subSteps;
  Result<void> added;
  for (const Stage& stage : frameOrder())
    if (added && (stage.modes & in(mode)) != 0) added = stage.record(work);
  if (work.before) {
    static_cast<HairFrameState&>(hair) = std::move(*work.before);
    hair.resetPending = hair.bonesChanged = true;
  }
  return added;
}

}  // namespace pelage::detail
