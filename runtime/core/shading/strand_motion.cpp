#include "shading/strand_motion.h"

#include <algorithm>
#include <utility>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

Result<void> addKeepPass(const MotionHair& hair, BufferId to, PassList& list) {
  const uint64_t bytes = hair.elements * sizeof(Float4);
  KeepPositionsConstants constants = {};
  constants.keptCount = static_cast<uint32_t>(hair.elements);
  constants.keptMovedFrom = static_cast<uint32_t>(std::min(hair.movedFrom, hair.elements));
  constants.keptMove = {hair.move.x, hair.move.y, hair.move.z, 0};
  PassBuilder builder(list);
  return dispatchRows(builder, keepPositionsVariant({}), hair.elements)
      .bytes(2 * bytes)
      .finish(KeepPositionsBindings{.keepPositionsConstants = constants,
                                    .positionsToKeep = {hair.positions, bytes},
                                    .keptPositions = {to, bytes}});
}

void StrandMotion::prepare(HairFrame& frame) {
  if (frame.mode == FrameMode::kPose) return;
  const bool there = positions_ != BufferId::kInvalid;
  if (there != frame.tracksMotion) {
    frame_ = 0;
    if (there)
      remove(frame.factory);
    else
      positions_ = frame.factory.add(frame.name + "/previousPositions", frame.storedVertices(),
                                     sizeof(Float4));
  }
  frame.buffers.previousPositions = positions_;
}

Result<void> StrandMotion::keep(const MotionHair& hair, PassList& list) const {
  if (positions_ == BufferId::kInvalid) return {};
  return addKeepPass(hair, positions_, list);
}

void StrandMotion::finish(const MotionHair& hair, bool reset, uint64_t frame) {
  const bool first = reset || frame_ == 0;
  const float before = std::exchange(nextTipSeparation_, hair.tipSeparation);
  tipSeparation_ = first ? hair.tipSeparation : before;
  frame_ = positions_ != BufferId::kInvalid ? frame : 0;
}

StrandsBefore StrandMotion::before(uint64_t frame) const {
  if (frame_ != frame || frame_ == 0) return {};
  return {positions_, tipSeparation_};
}

}  // namespace pelage::detail
