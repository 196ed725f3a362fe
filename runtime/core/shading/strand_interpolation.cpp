#include "shading/strand_interpolation.h"

#include "base/local_origin.h"
#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"

namespace pelage::detail {

void StrandInterpolation::prepare(HairFrame& frame) {
  if (frame.mode == FrameMode::kPose) return;
  if (isOn() != frame.interpolates) {
    known_ = false;
    forgetDrawn();
    if (frame.interpolates)
      makeBuffers(frame);
    else
      remove(frame.factory);
  }
  frame.buffers.drawnPositions = positions_;
  frame.buffers.drawnTangents = tangents_;
  frame.buffers.drawnRoots = roots_;
}

void StrandInterpolation::makeBuffers(const HairFrame& frame) {
  const uint64_t vertices = frame.storedVertices();
  const auto add = [&](const char* what, uint64_t elements, uint32_t stride) {
    return frame.factory.add(frame.name + "/" + what, elements, stride);
  };
  before_ = add("positionsBefore", vertices, sizeof(Float4));
  positions_ = add("drawnPositions", vertices, sizeof(Float4));
  tangents_ = add("drawnTangents", vertices, sizeof(Float4));
  // Drawing computes follow hairs that are not stored from guides and roots.
  if (frame.followCount > 0 && !frame.groom.storesFollowHairs)
    roots_ = add("drawnRoots", simulation::kRootSets * uint64_t{frame.guideCount},
                 sizeof(RootTransform));
}

void StrandInterpolation::remove(const BufferFactory& factory) {
  for (BufferId* buffer : {&before_, &positions_, &tangents_, &roots_}) factory.remove(*buffer);
}

Result<void> StrandInterpolation::keep(const MotionHair& hair, PassList& list) const {
  return addKeepPass(hair, before_, list);
}

void StrandInterpolation::finishState(bool reset, const Ball& ball) {
  if (reset) forgetDrawn();
  ballBefore_ = reset || !known_ ? ball : ballNow_;
  ballNow_ = ball;
  known_ = isOn();
}

Result<void> StrandInterpolation::record(const InterpolatedHair& hair, float share, bool known,
                                         bool restarts, PassList& list) const {
  const uint64_t bytes = hair.positions.elements * sizeof(Float4);
  InterpolateStrandsConstants strands = {};
  strands.interpolatedCount = static_cast<uint32_t>(hair.positions.elements);
  strands.interpolatedVertices = hair.vertices;
  strands.interpolatedShare = known ? share : 1;
  PassBuilder builder(list);
  dispatchRows(builder, interpolateStrandsVariant({}), hair.positions.elements);
  Result<void> added = builder.bytes(4 * bytes).finish(InterpolateStrandsBindings{
      .interpolateStrandsConstants = strands,
      .positionsBefore = {known ? before_ : hair.positions.positions, bytes},
      .positionsNow = {hair.positions.positions, bytes},
      .drawnPositions = {positions_, bytes},
      .drawnTangents = {tangents_, bytes}});
  if (!added || roots_ == BufferId::kInvalid) return added;
  const uint64_t rootBytes = simulation::kRootSets * uint64_t{hair.guides} * sizeof(RootTransform);
  InterpolateRootsConstants roots = {};
  roots.interpolatedRoots = hair.guides;
  roots.interpolatedRootShare = strands.interpolatedShare;
  roots.rootsRestart = restarts ? 1 : 0;
  dispatchRows(builder, interpolateRootsVariant({}), hair.guides);
  return builder.bytes(2 * rootBytes)
      .finish(InterpolateRootsBindings{.interpolateRootsConstants = roots,
                                       .stateRoots = hair.roots,
                                       .drawnRoots = {roots_, rootBytes}});
}

void StrandInterpolation::move(const WorldMove& move) {
  for (Ball* ball : {&ballBefore_, &ballNow_})
    ball->center = toFloat3(move.rigid(toVector(ball->center)));
  if (move.shifted == nullptr) forgetDrawn();
}

}  // namespace pelage::detail
