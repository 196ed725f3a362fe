// The frames of a scene: the order of the rooms, and what they hand on.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "contact/capsules.h"
#include "pelage/gpu_structs.h"
#include "scene/scene_impl.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

Result<void> SceneImpl::simulate(float dt, PassList& list) {
  list.clear();
  settleFrames(true);
  if (!std::isfinite(dt) || dt < 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "time step is " + std::to_string(dt) + " s, but must be finite and at least 0"};
  }
  if (dt == 0) {
    Result<void> moved = addPendingShifts(list);
    if (moved) moved = poseNewHair(list);
    if (moved)
      finishShift();
    else
      list.clear();
    return moved;
  }
  // A frame of 1/60 s that is a little long by rounding is still one step.
  const double steps = std::ceil(static_cast<double>(dt) / kReferenceStep - 1e-3);
  const auto subSteps = static_cast<uint32_t>(std::clamp(steps, 1.0, double{Scene::kMaxSubSteps}));
  const auto frame =
      static_cast<float>(std::min(static_cast<double>(dt), Scene::kMaxSubSteps * kReferenceStep));
  saveFrame();
  Result<void> done = simulateFrame(frame, subSteps, list);
  frames_.recording = false;
  frames_.open.back().lastVersion = resources_.version();
  if (!done) {
    list.clear();
    restoreFrame();
    return done;
  }
  time_ += static_cast<double>(frame);
  list.frame = frames_.open.back().number;
  return {};
}

// Where hair can collide with the meshes of the scene.
std::optional<HairReach> SceneImpl::reachOf(const HairObject& object) const {
  if (!object.usesMeshColliders || !isSimulated(object)) return std::nullopt;
  const HairInternals& hair = *object.internals_;
  return HairReach{ballOfCollisions(hair, object.settings.tipSeparation),
                   hair.meshColliders ? &*hair.meshColliders : nullptr};
}

Result<void> SceneImpl::simulateFrame(float length, uint32_t steps, PassList& list) {
  if (Result<void> valid = checkSkeletons(); !valid) return valid;
  followSkeletons();
  std::vector<HairReach> reaches;
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    if (Result<void> valid = checkObject(*object); !valid) {
      return Error{valid.error().code, "hair '" + object->name_ + "': " + valid.error().message};
    }
    if (const std::optional<HairReach> reach = reachOf(*object)) reaches.push_back(*reach);
  }
  const Result<SdfRoom::Plans> plans = sdfs_.check(reaches, room());
  if (!plans) return plans.error();
  sdfs_.plan(*plans, room());
  // A reset repairs everything: whoever asks for it may have lost a frame without knowing.
  for (const auto& object : objects_)
    if (object != nullptr && object->internals_->resetPending) sendAgain(*object->internals_);
  for (const auto& held : sdfs_.colliders)
    if (held != nullptr && held->internals_->resetPending) sendAgain(*held->internals_);
  if (Result<void> done = sdfs_.record(reaches, room(), list); !done) return done;
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    if (Result<void> done = simulateObject(*object, length, steps, list); !done) return done;
  }
  finishShift();
  return {};
}

// What an application can get wrong from frame to frame.
Result<void> SceneImpl::checkObject(const HairObject& object) const {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, what};
  };
  if (Result<void> valid = validate(object.settings); !valid) return valid;
  if (!(object.blendTime >= 0 && std::isfinite(object.blendTime)))
    return refuse("blendTime is " + std::to_string(object.blendTime) +
                  " s, but must be finite and at least 0");
  const float share = object.simulatedShare;
  const bool exact = object.settings.solver == Solver::kExact;
  if (exact && !(share >= 0 && share <= 1))
    return refuse("simulatedShare is " + std::to_string(share) + ", but must be in 0..1");
  if (exact && share < 1 && !object.internals_->levelOfDetail)
    return refuse("simulatedShare is below 1; set HairDef::levelOfDetail for it");
  if (const std::string fault = faultOf(object.internals_->field, resources_); !fault.empty())
    return refuse(fault);
  if (const BufferId id = object.buffers_.forces; id != BufferId::kInvalid) {
    const BufferDesc* forces = resources_.find(id);
    const uint64_t bytes =
        uint64_t{object.guideCount()} * object.verticesPerStrand() * sizeof(Float4);
    if (forces == nullptr || forces->size < bytes) {
      return refuse("the buffer of setForces() " +
                    (forces == nullptr ? "does not exist"
                                       : "has " + std::to_string(forces->size) + " bytes") +
                    "; it takes " + std::to_string(bytes));
    }
  }
  return {};
}

HairFrame SceneImpl::frameOf(HairObject& object, const SimulationSettings& settings, float length,
                             uint32_t steps, PassList& list) {
  HairInternals& hair = *object.internals_;
  return {.name = object.name_,
          .groom = hair,
          .settings = settings,
          .buffers = object.buffers_,
          .room = room(&object),
          .list = list,
          .roots = object.rootTransforms(),
          .guideCount = object.guideCount_,
          .followCount = object.followCount_,
          .vertexCount = object.vertexCount_,
          .boneCount = object.boneCount_,
          .simulatedShare = object.simulatedShare,
          .length = length,
          .steps = steps,
          .air = {},
          .loadShare = loadShareOf(settings),
          .reset = false,
          .stateOrigin = hair.origin,
          .origin = hair.origin,
          .rebase = {},
          .contacts = hair.contacts};
}

GridHair SceneImpl::gridHairOf(const HairFrame& frame, const HairInternals& hair) {
  return {.name = frame.name,
          .groom = hair,
          .bounds = hair.bounds,
          .bones = hair.bones,
          .deviation = hair.deviation,
          .shifted = hair.origin.shifted,
          .positions = frame.buffers.positions,
          .otherForces = forcesOf(frame, hair),
          .settings = frame.settings.contact};
}

FieldHair SceneImpl::fieldHairOf(const HairFrame& frame, const HairInternals& hair) {
  return {.name = frame.name,
          .field = hair.field,
          .vertices = frame.guideVertices(),
          .positions = frame.buffers.positions,
          .otherForces = frame.buffers.forces};
}

// Forces of the engine: those of a field have those of its own buffer in them.
BufferId SceneImpl::forcesOf(const HairFrame& frame, const HairInternals& hair) {
  const BufferId ofField = hair.fieldForces.forces();
  return ofField != BufferId::kInvalid ? ofField : frame.buffers.forces;
}

// Share of gravity, wind and forces since the object is simulated again.
float SceneImpl::blendOf(HairObject& object, float length) {
  HairInternals& hair = *object.internals_;
  if (std::exchange(hair.skinned, false)) hair.sinceSkinned = 0;
  const float since = hair.sinceSkinned;
  hair.sinceSkinned += length;
  return since < object.blendTime ? since / object.blendTime : 1.0f;
}

// \param shifted  elements, from the first, that are already where shifts of the world bring them
MotionHair SceneImpl::motionHairOf(const HairFrame& frame, const HairInternals& hair,
                                   uint64_t shifted) {
  const uint64_t follows = hair.storesFollowHairs ? frame.followCount : 0;
  MotionHair motion = {.name = frame.name,
                       .positions = frame.buffers.positions,
                       .elements = frame.guideVertices() + follows * frame.vertexCount,
                       .tipSeparation = frame.settings.tipSeparation};
  if (!frame.reset && !isZero(toFloat3(hair.pendingShift))) {
    motion.movedFrom = shifted;
    motion.move = toFloat3(-hair.pendingShift);
  }
  return motion;
}

Result<void> SceneImpl::simulateObject(HairObject& object, float length, uint32_t steps,
                                       PassList& list) {
  HairInternals& hair = *object.internals_;
  HairFrame frame = frameOf(object, object.settings, length, steps, list);
  if (hair.solver.prepare(frame)) hair.resetPending = true;
  if (hair.givenPositions.prepare(frame, hair.given)) hair.resetPending = true;
  if (hair.solver.restChanged()) {
    hair.bonesChanged = true;  // the roots are elsewhere
    hair.grid.remove(frame.room);
  }
  frame.roots = object.rootTransforms();
  frame.reset = hair.resetPending;
  if (!frame.reset) {
    if (Result<void> moved = addTeleport(frame, hair); !moved) return moved;
  }
  if (!isSimulated(object)) return skinObject(object, frame);
  frame.loadShare *= blendOf(object, length);
  frame.air = airAt(frame.settings.wind, time_, frame.loadShare);
  const FieldHair fieldHair = fieldHairOf(frame, hair);
  hair.fieldForces.prepare(fieldHair, frame.room);
  const GridHair gridHair = gridHairOf(frame, hair);
  hair.grid.prepare(gridHair, frame.settings.solver == Solver::kExact, frame.room);
  frame.buffers.contactForces = hair.grid.forces();
  // Shifts have moved the guides; stored follow hairs wait for the pass that places them.
  const MotionHair motion = motionHairOf(frame, hair, frame.guideVertices());
  prepareBefore(object, frame, motion);
  const bool touches = frame.buffers.contactForces != BufferId::kInvalid;
  frame.forces = touches ? frame.buffers.contactForces : forcesOf(frame, hair);
  if (Result<void> sent = beginBones(object, frame); !sent) return sent;
  frame.collidersReplaced = areReplaced(hair.collidersBefore, hair.colliders);
  sendSdfs(object, frame);
  sendCapsules(object, frame);
  hair.solver.prepareContacts(frame);
  // A reset writes all of it.
  if (!frame.reset) {
    if (Result<void> moved = addShiftPasses(frame, hair); !moved) return moved;
  }
  if (Result<void> kept = keepBefore(hair, frame, motion, frame.guideVertices()); !kept)
    return kept;
  // After two frames with the same bones both sets of transforms are the same.
  if (hair.stillFrames < 2) {
    if (Result<void> added = addRootPass(frame, hair.skinning); !added) return added;
  }
  if (Result<void> added = hair.fieldForces.record(fieldHair, !frame.reset, resources_, frame.list);
      !added)
    return added;
  if (Result<void> added = hair.solver.record(frame, hair.grid, gridHair); !added) return added;
  hair.grid.finish(gridHair, static_cast<double>(length));
  hair.resetPending = false;
  if (Result<void> placed = addFollowPass(frame); !placed) return placed;
  if (Result<void> moved = addFollowCollision(frame, hair.followContacts); !moved) return moved;
  return keepBehind(object, frame, motion);
}

// The object's origin and bones in a frame that moves it.
Result<void> SceneImpl::beginBones(HairObject& object, HairFrame& frame) const {
  HairInternals& hair = *object.internals_;
  frame.rebase = moveOrigin(hair);
  frame.origin = hair.origin;
  hair.stillFrames = hair.bonesChanged || frame.reset ? 0 : hair.stillFrames + 1;
  if (hair.bonesChanged) {
    if (Result<void> sent = sendBones(object, frame.list); !sent) return sent;
  }
  hair.bonesChanged = false;
  return {};
}

Result<void> SceneImpl::sendBones(HairObject& object, PassList& list) const {
  HairInternals& hair = *object.internals_;
  if (hair.skeleton != nullptr) {
    const Result<void> sent = detail::sendBones(*hair.skeleton, hair.skinning, resources_, list);
    if (!sent) return sent;
  } else {
    const std::vector<Float4> bones = packBones(hair.bones, hair.origin, hair.skinning);
    addUpload(list, object.buffers_.boneTransforms, std::as_bytes(std::span(bones)));
  }
  hair.bonesBefore = hair.bones;
  return {};
}

// The fields that an object's strands can reach.
void SceneImpl::sendSdfs(HairObject& object, HairFrame& frame) {
  HairInternals& hair = *object.internals_;
  SdfRoom::InReach found;
  if (const std::optional<HairReach> reach = reachOf(object))
    found = sdfs_.inReach(*reach, hair.origin);
  const HostArray<std::byte> bytes = bytesOf(found.sdfs);
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
  frame.colliders.contactSdfKeys = sdfs_.keys;
  frame.colliders.contactSdfSurface = sdfs_.surface;
}

void SceneImpl::sendCapsules(HairObject& object, HairFrame& frame) {
  HairInternals& hair = *object.internals_;
  forgetRounding(hair);
  // What sleeps does not look whether a capsule reaches its follow hairs.
  if (hair.collidesFollowHairs && hair.colliders != hair.collidersBefore)
    frame.collidersReplaced = true;
  const std::vector<Collider> packed =
      packCapsules(hair.colliders, hair.collidersBefore, hair.origin,
                   ballOfCollisions(hair, frame.settings.tipSeparation), frame.length);
  const auto count = static_cast<uint32_t>(packed.size());
  // Permutations with fields have the capsules' code, and want their buffer.
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

}  // namespace pelage::detail
