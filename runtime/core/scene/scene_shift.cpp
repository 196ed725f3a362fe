// Shifts of the world's origin. Solvers' states are relative to origins of their own and stay as
// they are; the outputs, which are in world space, are written anew or moved by the list that comes
// next.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pelage/kernels.h"
#include "scene/scene_delivery.h"
#include "scene/scene_frame.h"
#include "sdf/sdf_collider.h"

namespace pelage {

using detail::kVector;
using detail::Vector3;

namespace {

// Threads of a dispatch in x, as in the kernels.
constexpr uint64_t kRow = uint64_t{1} << 20;
// Floats beyond it are not whole metres any more [m].
constexpr float kMaxShift = 0x1p24f;

bool isZero(const Vector3<double>& v) { return v.x == 0 && v.y == 0 && v.z == 0; }

// Threads in x and y of a dispatch in rows.
void dispatchRows(PassBuilder& builder, const KernelVariant& variant, uint64_t threads) {
  builder.dispatch(variant, static_cast<uint32_t>(std::min(threads, kRow)),
                   static_cast<uint32_t>((threads + kRow - 1) / kRow));
}

}  // namespace

Vector3<double> Scene::shifted() const { return {shifted_[0], shifted_[1], shifted_[2]}; }

Result<void> Scene::shiftOrigin(Float3 shift) {
  for (const auto& [value, axis] :
       {std::pair(shift.x, "x"), std::pair(shift.y, "y"), std::pair(shift.z, "z")}) {
    if (std::abs(value) <= kMaxShift) continue;
    return Error{ErrorCode::kInvalidArgument, std::string("shiftOrigin(): ") + axis + " is " +
                                                  std::to_string(value) +
                                                  " m, but must be in -16777216..16777216"};
  }
  const Vector3<double> by = detail::toDouble3(shift);
  shifted_ = {shifted_[0] + by.x, shifted_[1] + by.y, shifted_[2] + by.z};
  for (const auto& skeleton : skeletons_)
    if (skeleton != nullptr) detail::shiftWorld(*skeleton->internals_, by, shifted());
  for (const auto& held : colliders_)
    if (held != nullptr) detail::shiftWorld(*held->internals_, by, shifted());
  for (const auto& object : objects_)
    if (object != nullptr) detail::shiftWorld(*object->internals_, by, shifted());
  shiftFrames(by);
  return {};
}

// What open frames are taken back to is in the new coordinates, too.
void Scene::shiftFrames(const Vector3<double>& by) {
  if (frames_ == nullptr) return;
  for (detail::FrameCheckpoint& frame : frames_->open) {
    for (detail::HairCheckpoint& saved : frame.hairs)
      detail::shiftWorld(saved.state, by, shifted());
    for (detail::ColliderCheckpoint& saved : frame.colliders) {
      detail::shiftWorld(saved.state, by, shifted());
      if (saved.collider->internals_->data) saved.state.grid = saved.collider->internals_->grid;
    }
    for (detail::SkeletonCheckpoint& saved : frame.skeletons) saved.origin.shifted = shifted();
  }
}

// For a list that does not simulate.
Result<void> Scene::addPendingShifts(PassList& list) {
  const bool pending = std::any_of(objects_.begin(), objects_.end(), [](const auto& object) {
    return object != nullptr && !isZero(object->internals_->pendingShift);
  });
  if (!pending) return {};
  // Where the list does not run, the next one has to move the outputs.
  if (list.frame == 0) {
    settleFrames(false);
    saveFrame();
    frames_->recording = false;
    frames_->open.back().lastVersion = resources_.version();
    list.frame = frames_->open.back().number;
  }
  for (const auto& object : objects_) {
    if (object == nullptr || isZero(object->internals_->pendingShift)) continue;
    detail::HairInternals& internals = *object->internals_;
    const Frame frame = {.object = *object,
                         .internals = internals,
                         .settings = object->settings,
                         .list = list,
                         .length = internals.lastFrame,
                         .steps = 1,
                         .air = {},
                         .reset = false,
                         .stateOrigin = internals.origin,
                         .rebase = {},
                         .colliderCount = 0,
                         .fieldCount = 0,
                         .sleeps = false,
                         .collidersReplaced = false};
    if (Result<void> added = addShiftPasses(frame); !added) return added;
    if (Result<void> added = addFollowShift(frame); !added) return added;
  }
  return {};
}

// Once a list has all that addPendingShifts() or simulateObject() adds.
void Scene::finishShift() {
  for (const auto& object : objects_) {
    if (object == nullptr || isZero(object->internals_->pendingShift)) continue;
    object->internals_->pendingShift = {};
    object->internals_->contacts.shiftWorld(shifted());
  }
}

// The guides, and what the next sub-step goes on from.
Result<void> Scene::addShiftPasses(const Frame& frame) {
  detail::HairInternals& internals = frame.internals;
  if (isZero(internals.pendingShift)) return {};
  const Result<void> rewritten =
      internals.solver == Solver::kExact ? addExactRewrite(frame) : addClassicRewrite(frame);
  if (!rewritten) return rewritten;
  internals.followsShifted = internals.storesFollowHairs;
  const detail::HairContacts& contacts = internals.contacts;
  if (contacts.before() != BufferId::kInvalid) {
    Result<void> added = addShift(frame, contacts.before(), 0, contacts.vertexCount());
    if (!added) return added;
  }
  if (internals.grid.size > 0 && internals.grid.history > 0) {
    const uint64_t vertices = uint64_t{frame.object.guideCount_} * frame.object.vertexCount_;
    Result<void> added = addShift(frame, frame.object.buffers_.contactVertices, 0, vertices);
    if (!added) return added;
  }
  if (!internals.followsCollided) return {};
  return addShift(frame, internals.followContacts.before(), 0,
                  internals.followContacts.beforeCount());
}

// Stored follow hairs, which a simulation places anew in any case.
Result<void> Scene::addFollowShift(const Frame& frame) {
  const HairObject& object = frame.object;
  if (!frame.internals.storesFollowHairs) return {};
  if (!frame.internals.followsCollided) return addFollowPass(frame);
  const uint64_t first = uint64_t{object.guideCount_} * object.vertexCount_;
  return addShift(frame, object.buffers_.positions, first,
                  uint64_t{object.followCount_} * object.vertexCount_);
}

Result<void> Scene::addShift(const Frame& frame, BufferId buffer, uint64_t first, uint64_t count) {
  const Float3 by = detail::toFloat3(-frame.internals.pendingShift);
  ShiftPositionsConstants constants = {};
  constants.shift = {by.x, by.y, by.z, 0};
  constants.shiftedFirst = static_cast<uint32_t>(first);
  constants.shiftedCount = static_cast<uint32_t>(count);
  PassBuilder builder(frame.list);
  dispatchRows(builder, shiftPositionsVariant({}), count);
  builder.bind("g_shiftedPositions", buffer, (first + count) * kVector)
      .constants("ShiftPositionsConstants", constants)
      .bytes(2 * count * kVector);
  return builder.finish();
}

Result<void> Scene::addExactRewrite(const Frame& frame) {
  const uint32_t guides = frame.object.guideCount_;
  ExactConstants constants = frame.exactConstants();
  const Float3 origin = frame.stateOrigin.world();
  constants.origin = {origin.x, origin.y, origin.z, 0};
  constants.rootEnd = 1;  // of the last frame
  PassBuilder builder(frame.list);
  dispatchRows(builder, rewriteExactPositionsVariant({}), constants.simulatedCount);
  bindExact(frame, builder);
  builder.constants("ExactConstants", constants)
      .bytes(uint64_t{constants.simulatedCount} * frame.object.vertexCount_ * 4 * kVector);
  if (Result<void> added = builder.finish(); !added) return added;
  if (constants.fadeStart == guides) return {};
  return addInterpolationPass(frame, constants, guides - constants.fadeStart);
}

Result<void> Scene::addClassicRewrite(const Frame& frame) {
  const HairBuffers& buffers = frame.object.buffers_;
  const uint64_t vertices = uint64_t{frame.object.guideCount_} * frame.object.vertexCount_;
  SimulationConstants constants = frame.commonConstants();
  const Float3 origin = frame.stateOrigin.world();
  constants.origin = {origin.x, origin.y, origin.z, 0};
  PassBuilder builder(frame.list);
  dispatchRows(builder, rewriteClassicPositionsVariant({}), vertices);
  builder.bind("g_positions", buffers.positions, vertices * kVector)
      .bind("g_state", buffers.state, detail::kClassicStateSets * vertices * kVector)
      .constants("SimulationConstants", constants)
      .bytes(3 * vertices * kVector);
  return builder.finish();
}

}  // namespace pelage
