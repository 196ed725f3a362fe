#include "simulation/given_positions.h"

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/kernels.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

void GivenPositions::prepare(HairFrame& frame) {
  const bool wasOn = buffer_ != BufferId::kInvalid;
  if (!frame.inputs.given.isOn()) {
    remove(frame.factory);
    frame.reset |= wasOn;
  } else if (!wasOn) {
    buffer_ = frame.factory.add(frame.name + "/givenPositions", frame.guideVertices(), kVector, {},
                                BufferUsage::kStorage | BufferUsage::kUpload);
    forget();
  }
}

Result<void> GivenPositions::record(const HairFrame& frame) {
  const GivenShape& shape = frame.inputs.given;
  if (buffer_ == BufferId::kInvalid) return {};
  if (frame.mode == FrameMode::kSkin && !frame.reset && version_ == shape.version) return {};
  if (version_ != shape.version)
    addUpload(frame.list, buffer_, std::as_bytes(std::span(shape.positions)));
  version_ = shape.version;
  const uint64_t bytes = frame.guideVertices() * kVector;
  // All of the way from the positions to themselves: what is left are the tangents.
  InterpolateStrandsConstants constants = {};
  constants.interpolatedCount = static_cast<uint32_t>(frame.guideVertices());
  constants.interpolatedVertices = frame.vertexCount;
  constants.interpolatedShare = 1;
  PassBuilder builder(frame.list);
  dispatchRows(builder, interpolateStrandsVariant({}), frame.guideVertices());
  return builder.bytes(3 * bytes).finish(InterpolateStrandsBindings{
      .interpolateStrandsConstants = constants,
      .positionsBefore = {buffer_, bytes},
      .positionsNow = {buffer_, bytes},
      .drawnPositions = {frame.buffers.positions, bytes},
      .drawnTangents = {frame.buffers.tangents, bytes},
  });
}

}  // namespace pelage::detail
