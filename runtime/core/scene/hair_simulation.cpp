#include "scene/hair_simulation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "scene/hair_order.h"

namespace pelage::detail {

namespace {

constexpr float kPoseStep = 1.0f / 60;  // [s]; the pose does not depend on it
static_assert(kMaxFrameSteps == Scene::kMaxSubSteps);

bool isNew(const HairObject& object) { return HairStore::of(object).resetPending; }

bool interpolates(const HairObject& object) {
  return object.interpolates || HairStore::of(object).get<StrandInterpolation>().isOn();
}

// Errors: what an application can get wrong from frame to frame.
Result<void> checkObject(const HairObject& object, const ResourceTable& resources) {
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
  if (exact && share < 1 && !HairStore::of(object).groom.levelOfDetail)
    return refuse("simulatedShare is below 1; set HairDef::levelOfDetail for it");
  if (const std::string fault = detail::faultOf(HairStore::of(object).field, resources);
      !fault.empty())
    return refuse(fault);
  if (const BufferId id = object.buffers().forces; id != BufferId::kInvalid) {
    const BufferDesc* forces = resources.find(id);
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

}  // namespace

Result<void> HairSimulation::simulate(float dt, PassList& list) {
  list.clear();
  journal_.settle(true);
  if (!std::isfinite(dt) || dt < 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "time step is " + std::to_string(dt) + " s, but must be finite and at least 0"};
  }
  if (dt == 0) {
    Result<void> moved = movePending(list);
    if (moved) moved = poseNewHair(list);
    if (moved)
      finishMoves();
    else
      list.clear();
    return moved;
  }
  // A frame of 1/60 s that is a little long by rounding is still one step.
  const double steps = std::ceil(static_cast<double>(dt) / kReferenceStep - 1e-3);
  const auto subSteps = static_cast<uint32_t>(std::clamp(steps, 1.0, double{Scene::kMaxSubSteps}));
  const auto length =
      static_cast<float>(std::min(static_cast<double>(dt), Scene::kMaxSubSteps * kReferenceStep));
  Result<void> done;
  {
    FrameJournal::Recording recording(journal_, list);
    done = simulateFrame(length, subSteps, list);
    if (done) recording.keep();
  }
  if (!done) {
    list.clear();
    return done;
  }
  store_.time += static_cast<double>(length);
  return {};
}

// \param onlyNew  hair that moves for the first time, or after a reset
Result<void> HairSimulation::checkHairs(bool onlyNew) const {
  for (const HairObject& object : store_.hairs()) {
    if (onlyNew && !isNew(object)) continue;
    if (Result<void> valid = checkObject(object, store_.resources); !valid)
      return Error{valid.error().code, "hair '" + object.name() + "': " + valid.error().message};
  }
  return {};
}

Result<void> HairSimulation::simulateFrame(float dt, uint32_t steps, PassList& list) {
  if (Result<void> valid = store_.checkSkeletons(); !valid) return valid;
  store_.followSkeletons();
  if (Result<void> valid = checkHairs(false); !valid) return valid;
  std::vector<HairReach>& reaches = reaches_;
  reaches.clear();
  for (const HairObject& object : store_.hairs())
    if (const std::optional<HairReach> reach = reachOf(object)) reaches.push_back(*reach);
  SdfRoom& sdfs = store_.sdfs;
  if (Result<void> checked = sdfs.check(reaches, store_.factory()); !checked) return checked;
  sdfs.plan(store_.factory());
  // A reset repairs everything: whoever asks for it may have lost a frame without knowing.
  for (HairObject& object : store_.hairs())
    if (isNew(object)) sendAgain(HairStore::of(object));
  for (SdfCollider& held : store_.colliders())
    if (HairStore::of(held).resetPending) sendAgain(HairStore::of(held));
  if (Result<void> done = sdfs.record(reaches, store_.factory(), list); !done) return done;
  for (HairObject& object : store_.hairs()) {
    const FrameMode mode = isSimulated(object) ? FrameMode::kSimulate : FrameMode::kSkin;
    Result<void> done = recordHair(store_, object, mode, {.dt = dt, .steps = steps}, list);
    if (!done) return done;
  }
  finishMoves();
  return {};
}

// In a frame of 0 s, hair that has not moved yet is shown in its bind pose under the bones. Its
// reset waits for the first frame that moves it.
Result<void> HairSimulation::poseNewHair(PassList& list) {
  if (std::ranges::none_of(store_.hairs(), isNew)) return {};
  if (Result<void> valid = store_.checkSkeletons(); !valid) return valid;
  if (Result<void> valid = checkHairs(true); !valid) return valid;
  FrameJournal::Recording recording(journal_, list);
  store_.followSkeletons();
  for (HairObject& object : store_.hairs()) {
    if (!isNew(object)) continue;
    Result<void> done = recordHair(store_, object, FrameMode::kPose, {.dt = kPoseStep}, list);
    if (!done) return done;
  }
  recording.keep();
  return {};
}

Result<void> HairSimulation::movePending(PassList& list) {
  const auto isPending = [](const HairObject& o) { return isMovePending(HairStore::of(o)); };
  if (std::ranges::none_of(store_.hairs(), isPending)) return {};
  // Where the list does not run, the next one has to move the outputs.
  std::optional<FrameJournal::Recording> recording;
  if (list.frame == 0) {
    journal_.settle(false);
    recording.emplace(journal_, list);
  }
  for (HairObject& object : store_.hairs()) {
    if (!isPending(object)) continue;
    Result<void> moved = recordHair(store_, object, FrameMode::kMove, {}, list);
    if (!moved) return moved;
  }
  if (recording) recording->keep();
  return {};
}

void HairSimulation::finishMoves() {
  for (HairObject& object : store_.hairs()) {
    HairInternals& hair = HairStore::of(object);
    if (!isMovePending(hair)) continue;
    hair.pendingShift = {};
    hair.teleport.reset();
    hair.get<HairColliders>().contacts().shiftWorld(store_.shifted);
  }
}

Result<void> HairSimulation::interpolate(float share, PassList& list) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "interpolate(): " + what};
  };
  // Also for NaN.
  if (!(share >= 0 && share <= 1))
    return refuse("the share is " + std::to_string(share) + ", but must be in 0..1");
  if (std::ranges::none_of(store_.hairs(), interpolates)) return {};
  journal_.settle(false);
  if (list.frame != 0 && !journal_.isLast(list))
    return refuse("the list is that of an earlier frame: take the one of the last simulate()");
  if (Result<void> moved = movePending(list); !moved) return moved;
  finishMoves();
  Result<void> done;
  {
    FrameJournal::Recording recording(journal_, list);
    for (HairObject& object : store_.hairs())
      if (done && interpolates(object))
        done = recordHair(store_, object, FrameMode::kBetween, {.share = share}, list);
    if (done) recording.keep();
  }
  if (!done) list.clear();
  return done;
}

}  // namespace pelage::detail
