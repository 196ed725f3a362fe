// The passes that advance hair objects.
#include <algorithm>
#include <cmath>
#include <string>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "scene/scene_delivery.h"
#include "scene/scene_frame.h"
#include "sdf/sdf_collider.h"
#include "simulation/exact_solver.h"

namespace pelage {

using detail::bytesOf;
using detail::followThreads;
using detail::isZero;
using detail::kFollowArguments;
using detail::kRootTransformSets;
using detail::kSleepHead;
using detail::kVector;
using detail::tileCount;
using detail::usesVsp;

namespace {

// The step that the artist's 0..1 values are defined at [s].
constexpr double kReferenceStep = 1.0 / 60.0;
// Bits of SimulationConstants::flags, as in kernels/layouts/simulation.hlsli.
constexpr uint32_t kClassicReset = 1;
constexpr uint32_t kClassicRebase = 2;
constexpr uint32_t kDualQuaternions = 4;
// Stiffness 1 would be an infinite spring.
constexpr double kMaxGlobalStiffness = 0.9999;
// Beyond this the local shape's sweeps overshoot; found by sweeping it on curled strands.
constexpr double kMaxLocalStiffness = 0.95;

// Displacement in a step of t for 1 m/s2 [s2], at the terminal velocity that steps of 1/60 s have.
double squareOf(double t, double damping) {
  if (!(damping > 1e-6)) return t * t;
  return t * kReferenceStep * (1 - std::pow(1 - damping, t / kReferenceStep)) / damping;
}

// A share s of the way to a goal in 1/60 s as a share for a step of h: a spring of the same
// frequency, solved implicitly.
double mapStiffness(double s, double h) {
  const double ratio = h / kReferenceStep;
  const double spring = ratio * ratio * s / (1 - s);
  return spring / (1 + spring);
}

bool usesGoals(const SimulationSettings& s) { return s.globalStiffness > 0 && s.globalRange > 0; }

}  // namespace

void Scene::removeSolverBuffers(HairObject& object) {
  HairBuffers& buffers = object.buffers_;
  for (BufferId* buffer : {&buffers.state, &buffers.rest, &buffers.strands, &buffers.gains,
                           &buffers.lengths, &buffers.sleep, &buffers.lodParents})
    removeBuffer(*buffer);
  removeContacts(object);
  object.internals_->solver.reset();
}

void Scene::removeContacts(HairObject& object) {
  for (BufferId* buffer : object.internals_->contacts.buffers()) removeBuffer(*buffer);
  object.buffers_.contacts = object.buffers_.contactWords = BufferId::kInvalid;
}

// Whether contacts are found in this frame; their buffers, and the totals of the frame.
void Scene::prepareContacts(Frame& frame) {
  HairObject& object = frame.object;
  detail::HairContacts& contacts = object.internals_->contacts;
  const bool exact = frame.settings.solver == Solver::kExact;
  // A reset of the classic solver takes the goals, and moves nothing.
  frame.contacts = (exact || !frame.reset) && (frame.colliderCount > 0 || frame.fieldCount > 0);
  if (frame.reset || !frame.contacts) contacts.forget();
  if (!frame.contacts) {
    contacts.clearTotals(frame.list);
    return;
  }
  if (!contacts.isPrepared(frame.steps * (exact ? frame.settings.subSteps : 1))) {
    removeContacts(object);
    std::vector<ContactStrand> strands;
    if (exact) {
      const detail::HairInternals& internals = frame.internals;
      for (const ExactStrand& s :
           detail::packExactStrands(internals.asset, internals.levelOfDetail).strands)
        strands.push_back({.target = s.target, .count = s.count, .root = s.root, .pad0 = 0});
    } else {
      for (uint32_t guide = 0; guide < object.guideCount_; ++guide)
        strands.push_back({.target = guide * object.vertexCount_,
                           .count = object.vertexCount_,
                           .root = guide,
                           .pad0 = 0});
    }
    contacts.prepare(resources_, object.name_, strands, object.vertexCount_,
                     uint64_t{object.guideCount_} * object.vertexCount_,
                     kMaxSubSteps * (exact ? frame.settings.subSteps : 1));
    object.buffers_.contacts = contacts.records();
    object.buffers_.contactWords = contacts.words();
  }
  contacts.begin(frame.list);
}

detail::ColliderBuffers Scene::colliderBuffers(const Frame& frame) const {
  const HairBuffers& buffers = frame.object.buffers_;
  return {.capsules = buffers.colliders,
          .capsuleCount = frame.colliderCount,
          .fields = buffers.fields,
          .fieldCount = frame.fieldCount,
          .fieldKeys = sdfKeys_,
          .fieldSurface = sdfSurface_};
}

Result<void> Scene::addContactPass(const Frame& frame, uint32_t step, uint32_t steps, bool again) {
  const HairBuffers& buffers = frame.object.buffers_;
  const bool exact = frame.settings.solver == Solver::kExact;
  const detail::ColliderBuffers colliders = colliderBuffers(frame);
  const detail::AwakeTiles awake = {.buffer = exact ? buffers.sleep : buffers.rootTransforms,
                                    .listed = frame.sleeps,
                                    .firstWord = detail::kSleepHead,
                                    .argumentBytes = detail::kFindArguments};
  const detail::ContactStep part = {.index = step,
                                    .begin = static_cast<float>(step) / static_cast<float>(steps),
                                    .end = static_cast<float>(step + 1) / static_cast<float>(steps),
                                    .length = frame.length / static_cast<float>(steps),
                                    .gravity = frame.settings.gravity,
                                    .again = again};
  const detail::ContactHair hair = {
      .positions = buffers.positions,
      .roots = buffers.rootTransforms,
      .rootCount = frame.object.guideCount_,
      .strands = exact ? frame.internals.simulatedCount : frame.object.guideCount_,
      .origin = frame.internals.origin};
  return frame.internals.contacts.find(frame.list, resources_, hair, colliders, awake, part);
}

// Makes the solver's buffers where those that are there are for something else.
void Scene::addSolverBuffers(HairObject& object) {
  detail::HairInternals& internals = *object.internals_;
  const HairAsset& asset = internals.asset;
  HairBuffers& buffers = object.buffers_;
  const Solver solver = object.settings.solver;
  const detail::RestSets sets = {
      .goals = solver == Solver::kExact && (usesGoals(object.settings) || internals.heldVertices),
      .factors = !internals.strandFactors.empty() || object.settings.curves != ParameterCurves{},
      .strands = internals.strandFactors,
      .curves = object.settings.curves};
  const auto add = [&](const char* what, uint64_t count, uint32_t stride,
                       std::vector<std::byte> initial = {},
                       BufferUsage usage = BufferUsage::kStorage) {
    return resources_.add({.name = object.name_ + "/" + what,
                           .size = count * stride,
                           .stride = stride,
                           .usage = usage,
                           .initial = std::move(initial)});
  };
  if (internals.solver != solver) {
    removeSolverBuffers(object);
    internals.solver = solver;
    internals.resetPending = true;
    if (solver == Solver::kClassic) {
      const uint64_t vertices = uint64_t{asset.strandCount} * asset.verticesPerStrand;
      buffers.state = add("state", detail::kClassicStateSets * vertices, kVector);
      buffers.lengths = add("lengths", vertices, sizeof(Float2));
    } else {
      const detail::ExactStrands strands = detail::packExactStrands(asset, internals.levelOfDetail);
      internals.stateStride = strands.stateStride;
      internals.slot = 0;
      buffers.strands =
          add("strands", strands.strands.size(), sizeof(ExactStrand), bytesOf(strands.strands));
      buffers.state =
          add("state", detail::exactStateCount(strands.stateStride, asset.strandCount), kVector);
      buffers.gains = add("gains", detail::kExactGainSets * strands.stateStride, kVector);
      if (internals.levelOfDetail) {
        const std::vector<uint32_t> parents = detail::nearStrandsBefore(asset, strands);
        buffers.lodParents = add("lodParents", parents.size(), sizeof(uint32_t), bytesOf(parents));
      }
      internals.simulatedCount = 0;
      const uint64_t tiles = tileCount(object.guideCount_);
      buffers.sleep =
          add("sleep", kSleepHead + 2 * tiles + object.guideCount_, sizeof(uint32_t), {},
              BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
                  BufferUsage::kReadback);
      internals.sleptBefore = false;
    }
  }
  if (buffers.rest != BufferId::kInvalid && sets == internals.restSets) return;
  internals.restSets = sets;
  removeBuffer(buffers.rest);
  std::vector<Float4> rest;
  if (solver == Solver::kExact) {
    rest = detail::packExactRest(asset, detail::packExactStrands(asset, internals.levelOfDetail),
                                 sets);
  } else {
    Result<std::vector<Float4>> packed = packRest(asset);
    PELAGE_ASSERT(packed, "addHair() takes processed assets only");
    rest = std::move(*packed);
    if (sets.factors) {
      const std::vector<Float4> factors = detail::packClassicFactors(asset, sets);
      rest.insert(rest.end(), factors.begin(), factors.end());
    }
  }
  buffers.rest = add("rest", rest.size(), kVector, bytesOf(rest));
}

Result<void> Scene::simulate(float dt, PassList& list) {
  list.clear();
  settleFrames(true);
  if (!std::isfinite(dt) || dt < 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "time step is " + std::to_string(dt) + " s, but must be finite and at least 0"};
  }
  if (dt == 0) {
    const Result<void> moved = addPendingShifts(list);
    if (moved)
      finishShift();
    else
      list.clear();
    return moved;
  }
  // A frame of 1/60 s that is a little long by rounding is still one step.
  const double steps = std::ceil(static_cast<double>(dt) / kReferenceStep - 1e-3);
  const auto subSteps = static_cast<uint32_t>(std::clamp(steps, 1.0, double{kMaxSubSteps}));
  const auto frame =
      static_cast<float>(std::min(static_cast<double>(dt), kMaxSubSteps * kReferenceStep));
  saveFrame();
  Result<void> done = simulateFrame(frame, subSteps, list);
  frames_->recording = false;
  frames_->open.back().lastVersion = resources_.version();
  if (!done) {
    list.clear();
    restoreFrame();
    return done;
  }
  time_ += static_cast<double>(frame);
  list.frame = frames_->open.back().number;
  return {};
}

Result<void> Scene::simulateFrame(float frame, uint32_t steps, PassList& list) {
  followSkeletons();
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    if (Result<void> valid = checkObject(*object); !valid) {
      return Error{valid.error().code, "hair '" + object->name_ + "': " + valid.error().message};
    }
  }
  Result<std::vector<std::optional<detail::SdfGridPlan>>> plans = checkColliders();
  if (!plans) return plans.error();
  bool grown = false;
  for (size_t i = 0; i < colliders_.size(); ++i) {
    if (!(*plans)[i]) continue;
    frames_->owner = colliders_[i];
    if (planCollider(*colliders_[i], *(*plans)[i])) grown = true;
  }
  frames_->owner = nullptr;
  if (grown) layOutFields();
  // A reset repairs everything: whoever asks for it may have lost a frame without knowing.
  for (const auto& object : objects_)
    if (object != nullptr && object->internals_->resetPending)
      detail::sendAgain(*object->internals_);
  for (const auto& held : colliders_)
    if (held != nullptr && held->internals_->resetPending) detail::sendAgain(*held->internals_);
  for (size_t place = 0; place < colliders_.size(); ++place) {
    if (colliders_[place] == nullptr) continue;
    frames_->owner = colliders_[place];
    if (Result<void> done = buildCollider(place, list); !done) return done;
  }
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    frames_->owner = object.get();
    if (Result<void> done = simulateObject(*object, frame, steps, list); !done) return done;
  }
  finishShift();
  return {};
}

// What an application can get wrong from frame to frame.
Result<void> Scene::checkObject(const HairObject& object) const {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, what};
  };
  if (Result<void> valid = validate(object.settings); !valid) return valid;
  const float share = object.simulatedShare;
  const bool exact = object.settings.solver == Solver::kExact;
  if (exact && !(share >= 0 && share <= 1))
    return refuse("simulatedShare is " + std::to_string(share) + ", but must be in 0..1");
  if (exact && share < 1 && !object.internals_->levelOfDetail)
    return refuse("simulatedShare is below 1; set HairDef::levelOfDetail for it");
  if (const BufferId id = object.buffers_.forces; id != BufferId::kInvalid) {
    const BufferDesc* forces = resources_.find(id);
    const uint64_t bytes = uint64_t{object.guideCount_} * object.vertexCount_ * kVector;
    if (forces == nullptr || forces->size < bytes) {
      return refuse("the buffer of setForces() " +
                    (forces == nullptr ? "does not exist"
                                       : "has " + std::to_string(forces->size) + " bytes") +
                    "; it takes " + std::to_string(bytes));
    }
  }
  return {};
}

Result<void> Scene::simulateObject(HairObject& object, float length, uint32_t steps,
                                   PassList& list) {
  const SimulationSettings& s = object.settings;
  addSolverBuffers(object);
  addHairGrid(object);
  detail::HairInternals& internals = *object.internals_;
  HairBuffers& buffers = object.buffers_;

  Frame frame = {
      .object = object,
      .internals = internals,
      .settings = s,
      .list = list,
      .length = length,
      .steps = steps,
      .air = detail::airAt(s.wind, time_),
      .reset = internals.resetPending,
      .stateOrigin = internals.origin,
      .rebase = detail::moveOrigin(internals),
      .colliderCount = 0,
      .fieldCount = 0,
      .sleeps = false,
      .collidersReplaced = detail::areReplaced(internals.collidersBefore, internals.colliders)};
  internals.stillFrames = internals.bonesChanged || frame.reset ? 0 : internals.stillFrames + 1;
  if (internals.skeleton != nullptr && internals.bonesChanged) {
    detail::uploadBones(*internals.skeleton, internals.skinning, list);
  } else if (internals.bonesChanged) {
    const std::vector<Float4> bones =
        detail::packBones(internals.bones, internals.origin, internals.skinning);
    addUpload(list, buffers.boneTransforms, std::as_bytes(std::span(bones)));
  }
  if (internals.bonesChanged) internals.bonesBefore = internals.bones;
  internals.bonesChanged = false;
  addFields(frame);
  detail::forgetRounding(internals);
  // What sleeps does not look whether a capsule reaches its follow hairs.
  if (internals.collidesFollowHairs && internals.colliders != internals.collidersBefore)
    frame.collidersReplaced = true;
  const std::vector<Collider> colliders = detail::packColliders(
      internals, detail::ballOfCollisions(internals, s.tipSeparation), length);
  frame.colliderCount = static_cast<uint32_t>(colliders.size());
  // Permutations with fields have the capsules' code, and want their buffer.
  const uint32_t wanted = std::max(frame.colliderCount, frame.fieldCount > 0 ? 1u : 0u);
  if (wanted > internals.colliderCapacity) {
    removeBuffer(buffers.colliders);
    internals.colliderCapacity = wanted;
    buffers.colliders = resources_.add({.name = object.name_ + "/colliders",
                                        .size = wanted * sizeof(Collider),
                                        .stride = sizeof(Collider),
                                        .usage = BufferUsage::kStorage | BufferUsage::kUpload});
  }
  if (!colliders.empty()) addUpload(list, buffers.colliders, std::as_bytes(std::span(colliders)));
  internals.collidersBefore = internals.colliders;
  prepareContacts(frame);
  // A reset writes all of it.
  if (!frame.reset) {
    if (Result<void> moved = addShiftPasses(frame); !moved) return moved;
  }

  if (Result<void> added = addRootPass(frame); !added) return added;
  const Result<void> added =
      s.solver == Solver::kExact ? addExactPasses(frame) : addClassicPasses(frame);
  if (!added) return added;
  finishHairGrid(object, static_cast<double>(length));
  internals.lastFrame = length;
  internals.resetPending = false;
  internals.settingsBefore = s;
  internals.followsShifted = false;
  if (Result<void> placed = addFollowPass(frame); !placed) return placed;
  return addFollowCollision(frame);
}

// What every kernel of the group "simulation" takes.
SimulationConstants Scene::Frame::commonConstants() const {
  const Float3 origin = internals.origin.world();
  SimulationConstants constants = {};
  constants.origin = {origin.x, origin.y, origin.z, 0};
  constants.rebase = {rebase.x, rebase.y, rebase.z, 0};
  constants.guideCount = object.guideCount_;
  constants.followCount = internals.storesFollowHairs ? object.followCount_ : 0;
  constants.vertexCount = object.vertexCount_;
  constants.boneCount = object.boneCount_;
  constants.timeStepRatio = 1;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  constants.tipSeparation = settings.tipSeparation;
  constants.flags = reset ? kClassicReset : 0;
  return constants;
}

Result<void> Scene::addRootPass(const Frame& frame) {
  // After two frames with the same bones both sets of transforms are the same.
  if (frame.internals.stillFrames >= 2) return {};
  const HairBuffers& buffers = frame.object.buffers_;
  const uint64_t guides = frame.object.guideCount_;
  SimulationConstants constants = frame.commonConstants();
  if (frame.internals.skinning == SkinningMethod::kDualQuaternions)
    constants.flags |= kDualQuaternions;
  PassBuilder builder(frame.list);
  builder.dispatch(skinRootsVariant(), frame.object.guideCount_)
      .bind("g_rest", buffers.bindRoots, guides * kVector)
      .bind("g_rootTransforms", buffers.rootTransforms,
            kRootTransformSets * guides * sizeof(RootTransform))
      .bind("g_boneTransforms", buffers.boneTransforms,
            detail::rowsOf(frame.internals.skinning) * frame.internals.bones.size() * kVector)
      .bind("g_rootBindings", buffers.rootBindings, guides * sizeof(RootBinding))
      .constants("SimulationConstants", constants)
      .bytes(guides * (sizeof(RootBinding) + kVector + 3 * sizeof(RootTransform)));
  return builder.finish();
}

Result<void> Scene::addClassicPasses(const Frame& frame) {
  const SimulationSettings& s = frame.settings;
  HairObject& object = frame.object;
  detail::HairInternals& internals = frame.internals;
  const HairBuffers& buffers = object.buffers_;
  const uint64_t guides = object.guideCount_;
  const uint64_t vertices = guides * object.vertexCount_;
  const double h = static_cast<double>(frame.length) / frame.steps;
  // Forces are found for steps of 1/60 s or more, and shorter steps take a share of them.
  const double forceStep = std::max(h, kReferenceStep);
  const double damping = static_cast<double>(s.damping);

  SimulationConstants constants = frame.commonConstants();
  constants.gravity = {s.gravity.x, s.gravity.y, s.gravity.z, 0};
  const Float3 wind = frame.air.velocity;
  constants.wind = {wind.x, wind.y, wind.z, s.airDrag};
  const Float3 gust0 = frame.air.gust0, gust1 = frame.air.gust1;
  constants.gust0 = {gust0.x, gust0.y, gust0.z, s.wind.strandVariation};
  constants.gust1 = {gust1.x, gust1.y, gust1.z, 0};
  constants.factorSet = internals.restSets.factors ? 2 : 0;
  constants.timeStep = static_cast<float>(h);
  constants.dampingKeep = static_cast<float>(std::pow(1 - damping, forceStep / kReferenceStep));
  constants.gravityStep = static_cast<float>(squareOf(forceStep, damping));
  constants.forceShare = static_cast<float>(squareOf(h, damping) / squareOf(forceStep, damping));
  constants.localStiffness = static_cast<float>(
      mapStiffness(std::min(static_cast<double>(s.localStiffness), kMaxLocalStiffness), forceStep));
  if (usesGoals(s)) {
    constants.globalStiffness = static_cast<float>(mapStiffness(
        std::min(static_cast<double>(s.globalStiffness), kMaxGlobalStiffness), forceStep));
  }
  constants.globalRange = s.globalRange;
  constants.vspCoefficient = s.vspCoefficient;
  constants.vspThreshold = s.vspThreshold;
  constants.maxSpeed = s.maxSpeed;
  constants.localIterations = s.localStiffness > 0 ? s.localIterations : 0;
  constants.lengthIterations = s.lengthIterations;

  SimulateStrandsKey key;
  key.contacts = frame.contacts;
  key.forces = buffers.forces != BufferId::kInvalid;
  const detail::HairContacts& contacts = internals.contacts;
  constants.contactMasks = contacts.masks();
  constants.contactMaskWords = contacts.maskWords();
  // Still air does not drag.
  if (isZero(s.wind.velocity)) constants.wind.w = 0;
  const KernelVariant& variant = simulateStrandsVariant(key);
  const auto steps = static_cast<float>(frame.steps);
  for (uint32_t step = 0; step < frame.steps; ++step) {
    constants.flags = 0;
    if (step == 0 && frame.reset) constants.flags |= kClassicReset;
    if (step == 0 && !isZero(frame.rebase)) constants.flags |= kClassicRebase;
    constants.rootBegin = static_cast<float>(step) / steps;
    constants.rootEnd = static_cast<float>(step + 1) / steps;
    constants.timeStepRatio =
        internals.lastStep > 0 ? constants.timeStep / internals.lastStep : 1.0f;
    internals.lastStep = constants.timeStep;
    if (frame.contacts) {
      if (Result<void> found = addContactPass(frame, step, frame.steps, false); !found)
        return found;
    }
    PassBuilder builder(frame.list);
    // State read and written twice each, rest data, positions and tangents.
    builder.dispatch(variant, object.guideCount_)
        .bind("g_positions", buffers.positions, vertices * kVector)
        .bind("g_tangents", buffers.tangents, vertices * kVector)
        .bind("g_state", buffers.state, detail::kClassicStateSets * vertices * kVector)
        .bind("g_lengths", buffers.lengths, vertices * sizeof(Float2))
        .bind("g_contacts", contacts.records(), contacts.recordBytes())
        .bind("g_contactWords", contacts.words(), contacts.wordBytes())
        .bind("g_rest", buffers.rest, (internals.restSets.factors ? 3 : 2) * vertices * kVector)
        .bind("g_strandForces", buffers.forces, vertices * kVector)
        .bind("g_rootTransforms", buffers.rootTransforms,
              kRootTransformSets * guides * sizeof(RootTransform))
        .constants("SimulationConstants", constants)
        .bytes(8 * vertices * kVector + 2 * guides * sizeof(RootTransform));
    if (Result<void> added = builder.finish(); !added) return added;
  }
  return {};
}

Result<void> Scene::addFollowPass(const Frame& frame) {
  const HairObject& object = frame.object;
  const HairBuffers& buffers = object.buffers_;
  const uint64_t guides = object.guideCount_;
  const uint64_t follows = object.followCount_;
  const uint64_t vertices = object.vertexCount_;
  if (!frame.internals.storesFollowHairs) return {};
  SimulationConstants constants = frame.commonConstants();
  constants.flags = 0;
  PassBuilder builder(frame.list);
  if (frame.sleeps)
    builder.dispatchIndirect(updateFollowStrandsVariant({}), buffers.sleep, kFollowArguments);
  else
    builder.dispatch(updateFollowStrandsVariant({}), followThreads(object.followCount_),
                     object.vertexCount_);
  builder.bind("g_positions", buffers.positions, (guides + follows) * vertices * kVector)
      .bind("g_tangents", buffers.tangents, (guides + follows) * vertices * kVector)
      .bind("g_rest", buffers.bindRoots, guides * kVector)
      .bind("g_rootTransforms", buffers.rootTransforms,
            kRootTransformSets * guides * sizeof(RootTransform))
      .bind("g_followStrands", buffers.followStrands, follows * sizeof(FollowStrand))
      .constants("SimulationConstants", constants)
      .bytes(follows * (sizeof(FollowStrand) + 3 * vertices * kVector));
  return builder.finish();
}

Result<void> Scene::addFollowCollision(const Frame& frame) {
  HairObject& object = frame.object;
  detail::HairInternals& internals = frame.internals;
  HairBuffers& buffers = object.buffers_;
  const bool known = internals.followsCollided && !frame.reset;
  internals.followsCollided = false;
  if (!internals.collidesFollowHairs) return {};
  if (frame.fieldCount == 0 && frame.colliderCount == 0) return {};
  detail::FollowContacts& contacts = internals.followContacts;
  if (!contacts.isPrepared()) {
    contacts.prepare(resources_, object.name_, object.followCount_, object.vertexCount_);
    buffers.followBefore = contacts.before();
    buffers.followContactWords = contacts.words();
  }
  detail::FollowHairs hairs = {.positions = buffers.positions,
                               .tangents = buffers.tangents,
                               .first = object.guideCount_,
                               .origin = internals.origin.world()};
  if (frame.sleeps) {
    hairs.awake = buffers.sleep;
    hairs.argumentBytes = kFollowArguments;
  }
  internals.followsCollided = true;
  return contacts.add(frame.list, resources_, hairs, colliderBuffers(frame), known);
}

}  // namespace pelage
