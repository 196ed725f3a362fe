#include "scene/hair_order.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "contact/capsules.h"
#include "pelage/gpu_structs.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

/// An object whose passes are recorded.
struct HairWork {
  HairStore& store;
  HairObject& object;
  HairInternals& hair;
  FrameMode mode;
  HairFrame frame;
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

GridHair gridHairOf(const HairWork& work) {
  const HairInternals& hair = work.hair;
  const BufferId ofField = hair.fieldForces.forces();
  const BufferId ofEngine = work.frame.buffers.forces;
  return {.name = work.frame.name,
          .groom = hair,
          .bounds = hair.bounds,
          .bones = hair.bones,
          .deviation = hair.deviation,
          .shifted = hair.origin.shifted,
          .positions = work.frame.buffers.positions,
          // A field adds its forces to the engine's.
          .otherForces = ofField != BufferId::kInvalid ? ofField : ofEngine,
          .settings = work.frame.settings.contact};
}

FieldHair fieldHairOf(const HairWork& work) {
  return {.name = work.frame.name,
          .field = work.hair.field,
          .vertices = work.frame.guideVertices(),
          .positions = work.frame.buffers.positions,
          .otherForces = work.frame.buffers.forces};
}

// \param moved  elements, from the first, that are already where shifts of the world bring them
MotionHair motionHairOf(const HairFrame& frame, const HairInternals& hair, uint64_t moved = 0) {
  const uint64_t follows = hair.storesFollowHairs ? frame.followCount : 0;
  MotionHair motion = {.name = frame.name,
                       .positions = frame.buffers.positions,
                       .elements = frame.guideVertices() + follows * frame.vertexCount,
                       .tipSeparation = frame.settings.tipSeparation};
  if (!frame.reset && !isZero(toFloat3(hair.pendingShift))) {
    motion.movedFrom = moved;
    motion.move = toFloat3(-hair.pendingShift);
  }
  return motion;
}

// Shifts and teleports have moved the guides of simulated hair before its positions are kept.
uint64_t movedElements(const HairWork& work) {
  return work.mode == FrameMode::kSimulate ? work.frame.guideVertices() : 0;
}

InterpolatedHair interpolatedHairOf(const HairFrame& frame, const HairInternals& hair,
                                    const MotionHair& positions) {
  return {.positions = positions,
          .vertices = frame.vertexCount,
          .guides = frame.guideCount,
          .roots = frame.roots,
          .evaluatesFollows = frame.followCount > 0 && !hair.storesFollowHairs};
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

void prepareBefore(const HairObject& object, HairInternals& hair, HairFrame& frame) {
  const MotionHair motion = motionHairOf(frame, hair);
  hair.motion.prepare(motion, object.tracksMotion, frame.room);
  hair.interpolation.prepare(interpolatedHairOf(frame, hair, motion), object.interpolates,
                             frame.room);
  const StrandsBetween between = hair.interpolation.buffers();
  frame.buffers.previousPositions = hair.motion.positions();
  frame.buffers.drawnPositions = between.positions;
  frame.buffers.drawnTangents = between.tangents;
  frame.buffers.drawnRoots = between.roots;
}

// The stages of a frame: frameOrder() says which modes have them.

Result<void> prepareSolver(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  if (hair.solver.prepare(frame)) hair.resetPending = true;
  if (hair.givenPositions.prepare(frame, hair.given)) hair.resetPending = true;
  frame.roots = object.rootTransforms();
  frame.reset = hair.resetPending;
  if (mode == FrameMode::kPose) {
    before = hair;
    hair.grid.pause();
    sendAgain(hair);
    frame.reset = true;
  } else if (hair.solver.restChanged()) {
    hair.bonesChanged = true;  // the roots are elsewhere
    hair.grid.remove(frame.room);
  }
  return {};
}

// What rooms have on the GPU, but for positions.
Result<void> teleportStates(HairWork& work) {
  const HairInternals& hair = work.hair;
  if (!hair.teleport || work.frame.reset) return {};
  const RigidMove world = teleportInWorld(hair);
  for (const std::vector<MovedElements>& room :
       {hair.solver.moved(work.frame), hair.contacts.moved(),
        hair.grid.moved(work.frame.guideVertices()), hair.followContacts.moved()}) {
    for (const MovedElements& elements : room) {
      const RigidMove& move = elements.inWorld ? world : hair.teleport->move;
      if (Result<void> added = addRigidMove(work.frame, move, elements); !added) return added;
    }
  }
  return {};
}

Result<void> prepareRooms(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  const bool simulates = mode == FrameMode::kSimulate;
  if (simulates) {
    frame.loadShare *= blendOf(object, hair, frame.length);
    frame.air = airAt(frame.settings.wind, store.time, frame.loadShare);
    hair.fieldForces.prepare(fieldHairOf(work), frame.room);
  }
  const GridHair grid = gridHairOf(work);
  hair.grid.prepare(grid, simulates && frame.settings.solver == Solver::kExact, frame.room);
  frame.buffers.contactForces = hair.grid.forces();
  prepareBefore(object, hair, frame);
  const bool touches = frame.buffers.contactForces != BufferId::kInvalid;
  if (simulates) frame.forces = touches ? frame.buffers.contactForces : grid.otherForces;
  return {};
}

Result<void> placeBones(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  frame.rebase = moveOrigin(hair);
  frame.origin = hair.origin;
  hair.stillFrames = hair.bonesChanged || frame.reset ? 0 : hair.stillFrames + 1;
  if (!std::exchange(hair.bonesChanged, false)) return {};
  if (hair.skeleton != nullptr) {
    const Result<void> sent = sendBones(*hair.skeleton, hair.skinning, store.resources, frame.list);
    if (!sent) return sent;
  } else {
    const std::vector<Float4> bones = packBones(hair.bones, hair.origin, hair.skinning);
    addUpload(frame.list, frame.buffers.boneTransforms, std::as_bytes(std::span(bones)));
  }
  hair.bonesBefore = hair.bones;
  return {};
}

// The fields that an object's strands can reach.
void sendSdfs(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  SdfRoom::InReach found;
  if (const std::optional<HairReach> reach = reachOf(object))
    found = store.sdfs.inReach(*reach, hair.origin);
  const HostArray<std::byte> bytes = detail::bytesOf(found.sdfs);
  const auto count = static_cast<uint32_t>(found.sdfs.size());
  if (found.rebuilt || bytes != hair.sdfsBefore) frame.collidersReplaced = true;
  // Capsules come behind the fields.
  const uint32_t wanted = count > 0 ? count + static_cast<uint32_t>(hair.colliders.size()) : 0;
  if (wanted > hair.sdfCapacity) {
    frame.room.remove(frame.buffers.sdfs);
    hair.sdfCapacity = wanted;
    frame.buffers.sdfs = frame.room.add(frame.name + "/fields", wanted, sizeof(Sdf), {},
                                        BufferUsage::kStorage | BufferUsage::kUpload);
    hair.sdfsBefore.clear();
  }
  if (!bytes.empty() && bytes != hair.sdfsBefore) addUpload(frame.list, frame.buffers.sdfs, bytes);
  hair.sdfsBefore = bytes;
  frame.colliders.sdfs = frame.buffers.sdfs;
  frame.colliders.contactSdfCount = count;
  frame.colliders.hasDenseSdfs = found.dense;
  frame.colliders.contactSdfKeys = store.sdfs.keys;
  frame.colliders.contactSdfSurface = store.sdfs.surface;
}

void sendCapsules(HairInternals& hair, HairFrame& frame) {
  forgetRounding(hair);
  // Sleeping strands are not tested against capsules.
  if (hair.collidesFollowHairs && hair.colliders != hair.collidersBefore)
    frame.collidersReplaced = true;
  const std::vector<Collider> packed =
      packCapsules(hair.colliders, hair.collidersBefore, hair.origin,
                   ballOfCollisions(hair, frame.settings.tipSeparation), frame.length);
  const auto count = static_cast<uint32_t>(packed.size());
  // SDF permutations bind the capsule buffer, too.
  const uint32_t wanted = std::max(count, frame.colliders.contactSdfCount > 0 ? 1u : 0u);
  if (wanted > hair.colliderCapacity) {
    frame.room.remove(frame.buffers.colliders);
    hair.colliderCapacity = wanted;
    frame.buffers.colliders = frame.room.add(frame.name + "/colliders", wanted, sizeof(Collider),
                                             {}, BufferUsage::kStorage | BufferUsage::kUpload);
  }
  if (count > 0) {
    addUpload(frame.list, frame.buffers.colliders, std::as_bytes(std::span(packed)));
    if (const uint64_t fields = frame.colliders.contactSdfCount; fields > 0)
      addUpload(frame.list, frame.buffers.sdfs, std::as_bytes(std::span(packed)),
                fields * sizeof(Sdf));
  }
  hair.collidersBefore = hair.colliders;
  frame.colliders.capsules = frame.buffers.colliders;
  frame.colliders.capsuleCount = count;
}

Result<void> sendColliders(HairWork& work) {
  work.frame.collidersReplaced = areReplaced(work.hair.collidersBefore, work.hair.colliders);
  sendSdfs(work);
  sendCapsules(work.hair, work.frame);
  work.hair.solver.prepareContacts(work.frame);
  return {};
}

// Hair that collides again later has no history, and capsules have not moved meanwhile.
Result<void> pauseContacts(HairWork& work) {
  HairInternals& hair = work.hair;
  hair.contacts.forget();
  hair.contacts.clearTotals(work.frame.list);
  hair.followContacts.forget();
  hair.collidersBefore = hair.colliders;
  hair.roundedShift = 0;
  return {};
}

// The guides, and what the next sub-step goes on from. A reset writes all of it.
Result<void> shiftStates(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  if (frame.reset || !isMovePending(hair)) return {};
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

// Before anything moves the strands. With interpolation, motion is that between frames that draw.
Result<void> keepBefore(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  const uint64_t moved = movedElements(work);
  const MotionHair motion = motionHairOf(frame, hair, moved);
  if (!hair.interpolation.isOn())
    return startsStill(work) ? Result<void>() : hair.motion.keep(motion, frame.list);
  if (frame.reset) return {};
  if (!hair.teleport) return hair.interpolation.keep(motion, frame.list);
  MotionHair unmoved = motion;
  unmoved.movedFrom = ~uint64_t{0};
  Result<void> kept = hair.interpolation.keep(unmoved, frame.list);
  if (!kept || moved >= motion.elements) return kept;
  return addRigidMove(frame, teleportInWorld(hair, frame.stateOrigin),
                      {hair.interpolation.before(),
                       moved,
                       motion.elements - moved,
                       1,
                       {move_rigidly::kMovesPoint}});
}

// After two frames with the same bones both sets of transforms are the same.
Result<void> placeRoots(HairWork& work) {
  return work.hair.stillFrames < 2 ? addRootPass(work.frame, work.hair.skinning) : Result<void>();
}

Result<void> addFieldForces(HairWork& work) {
  return work.hair.fieldForces.record(fieldHairOf(work), !work.frame.reset, work.store.resources,
                                      work.frame.list);
}

Result<void> moveGuides(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  if (mode == FrameMode::kSimulate || (mode == FrameMode::kPose && isSimulated(object))) {
    const GridHair grid = gridHairOf(work);
    if (Result<void> added = hair.solver.record(frame, hair.grid, grid); !added) return added;
    hair.grid.finish(grid, static_cast<double>(frame.length));
    hair.resetPending = false;
    return {};
  }
  if (mode == FrameMode::kPose) return hair.solver.skin(frame);
  const bool posed = std::exchange(hair.skinned, true) && hair.stillFrames >= 2 &&
                     hair.pendingShift.x == 0 && hair.pendingShift.y == 0 &&
                     hair.pendingShift.z == 0;
  hair.resetPending = false;
  // Given positions initialize the solver's state once.
  const bool wanted = !posed && (!hair.given.isOn() || frame.reset);
  return wanted ? hair.solver.skin(frame) : Result<void>();
}

Result<void> placeGiven(HairWork& work) {
  const HairInternals& hair = work.hair;
  const bool known =
      work.mode == FrameMode::kSkin && !work.frame.reset && hair.givenPositions.has(hair.given);
  if (work.mode == FrameMode::kSkin && (!hair.given.isOn() || known)) return {};
  return work.hair.givenPositions.place(work.frame, hair.given);
}

// Stored follow hairs; where they have collided, a list that only moves hair moves them with it.
Result<void> placeFollows(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  if (mode != FrameMode::kMove || !hair.followContacts.goesOn()) return addFollowPass(frame);
  return {};
}

Result<void> collideFollows(HairWork& work) {
  return addFollowCollision(work.frame, work.hair.followContacts);
}

// What draws read.
Result<void> moveOutputs(HairWork& work) {
  const HairInternals& hair = work.hair;
  const HairFrame& frame = work.frame;
  const uint64_t count = motionHairOf(frame, hair).elements;
  const auto move = [&](BufferId buffer, uint64_t first, uint64_t elements) {
    if (hair.teleport)
      return addRigidMove(frame, teleportInWorld(hair),
                          {buffer, first, elements, 1, {move_rigidly::kMovesPoint}});
    return addShift(frame, toFloat3(-hair.pendingShift), buffer, first, elements);
  };
  Result<void> moved;
  if (hair.storesFollowHairs && hair.followContacts.goesOn())
    moved = move(frame.buffers.positions, frame.guideVertices(), count - frame.guideVertices());
  const BufferId drawnBefore = hair.motion.before(work.store.frame).positions;
  if (moved && drawnBefore != BufferId::kInvalid) moved = move(drawnBefore, 0, count);
  const StrandInterpolation& between = hair.interpolation;
  if (!between.isOn()) return moved;
  if (moved && (hair.teleport || between.knowsState())) moved = move(between.before(), 0, count);
  if (moved && !hair.teleport && between.hasDrawn())
    moved = move(between.buffers().positions, 0, count);
  return moved;
}

// Behind what has moved the strands: a reset has no state before.
Result<void> keepAfter(HairWork& work) {
  auto& [store, object, hair, mode, frame, before] = work;
  const MotionHair motion = motionHairOf(frame, hair, movedElements(work));
  if (!hair.interpolation.isOn()) {
    const bool still = startsStill(work);
    hair.motion.finish(motion, still, store.frame);
    return still ? hair.motion.keep(motion, frame.list) : Result<void>();
  }
  hair.interpolation.finishState(frame.reset, ballOfHair(hair, object.settings.tipSeparation));
  return frame.reset ? hair.interpolation.keep(motion, frame.list) : Result<void>();
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
      Stage{in(kSimulate, kSkin, kPose), prepareSolver},
      Stage{in(kSimulate, kSkin, kMove), teleportStates},
      Stage{in(kSimulate, kSkin), prepareRooms},
      Stage{in(kSimulate, kSkin, kPose), placeBones},
      Stage{in(kSimulate), sendColliders},
      Stage{in(kSkin), pauseContacts},
      Stage{in(kSimulate, kMove), shiftStates},
      Stage{in(kSimulate, kSkin), keepBefore},
      Stage{in(kSimulate, kSkin, kPose), placeRoots},
      Stage{in(kSimulate), addFieldForces},
      Stage{in(kSimulate, kSkin, kPose), moveGuides},
      Stage{in(kSkin, kPose, kMove), placeGiven},
      Stage{in(kSimulate, kSkin, kPose, kMove), placeFollows},
      Stage{in(kSimulate), collideFollows},
      Stage{in(kMove), moveOutputs},
      Stage{in(kSimulate, kSkin), keepAfter},
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

HairFrame frameOf(HairStore& store, HairObject& object, const SimulationSettings& settings,
                  FrameTime time, PassList& list) {
  HairInternals& hair = HairStore::of(object);
  return {.name = object.name(),
          .groom = hair,
          .settings = settings,
          .buffers = HairStore::buffersOf(object),
          .room = store.room(&object),
          .list = list,
          .roots = object.rootTransforms(),
          .guideCount = object.guideCount(),
          .followCount = object.followCount(),
          .vertexCount = object.verticesPerStrand(),
          .boneCount = object.boneCount(),
          .simulatedShare = object.simulatedShare,
          .length = time.dt,
          .steps = time.steps,
          .air = {},
          .loadShare = loadShareOf(settings),
          .reset = false,
          .stateOrigin = hair.origin,
          .origin = hair.origin,
          .rebase = {},
          .contacts = hair.contacts};
}

Result<void> recordHair(HairStore& store, HairObject& object, FrameMode mode, FrameTime time,
                        PassList& list) {
  HairInternals& hair = HairStore::of(object);
  std::optional<SimulationSettings> posed;
  if (mode == FrameMode::kPose) posed = withoutForces(object.settings);
  HairWork work = {store,
                   object,
                   hair,
                   mode,
                   frameOf(store, object, posed ? *posed : object.settings, time, list),
                   std::nullopt};
  Result<void> added;
  for (const Stage& stage : frameOrder())
    if (added && (stage.modes & in(mode)) != 0) added = stage.record(work);
  if (work.before) {
    static_cast<HairFrameState&>(hair) = std::move(*work.before);
    hair.resetPending = hair.bonesChanged = true;
  }
  return added;
}

Result<void> interpolateHair(HairStore& store, HairObject& object, float share, PassList& list) {
  HairInternals& hair = HairStore::of(object);
  HairFrame frame = frameOf(store, object, object.settings, {.dt = hair.solver.lastFrame()}, list);
  const MotionHair now = motionHairOf(frame, hair);
  prepareBefore(object, hair, frame);
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
  hair.interpolation.finish(store.frame);
  hair.motion.finish(drawn, restarts, store.frame);
  return restarts ? hair.motion.keep(drawn, list) : Result<void>();
}

}  // namespace pelage::detail
