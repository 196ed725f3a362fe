#include "simulation/field_forces.h"

#include <algorithm>
#include <cmath>

#include "base/finite.h"
#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kForceSize = sizeof(Float4);

}  // namespace

std::string faultOf(const ForceField& field, const ResourceTable& resources) {
  if (field.values == BufferId::kInvalid) return {};
  const auto fault = [](const std::string& what) { return "its force field " + what; };
  const BufferDesc* values = resources.find(field.values);
  if (values == nullptr) return fault("is in a buffer that does not exist");
  if (!isFinite(field.origin)) return fault("has an origin that is not finite");
  if (!(field.cellSize > 0) || !std::isfinite(field.cellSize)) {
    return fault("has cells of " + std::to_string(field.cellSize) +
                 " m, but their size must be finite and above 0");
  }
  const auto [x, y, z] = field.nodes;
  const std::string size =
      std::to_string(x) + " x " + std::to_string(y) + " x " + std::to_string(z) + " nodes";
  if (std::min({x, y, z}) < 2) return fault("has " + size + ", but takes 2 or more along an axis");
  // Without an overflow.
  const double nodes = static_cast<double>(x) * y * z + field.first;
  if (nodes * kForceSize <= static_cast<double>(values->size)) return {};
  return fault("has " + size + " from element " + std::to_string(field.first) +
               " on, but its buffer only " + std::to_string(values->size) + " bytes");
}

void FieldForces::prepare(HairFrame& frame) {
  if (frame.mode != FrameMode::kSimulate) return;
  if (frame.inputs.field.values == BufferId::kInvalid)
    remove(frame.factory);
  else if (forces_ == BufferId::kInvalid)
    forces_ = frame.factory.add(frame.name + "/fieldForces", frame.guideVertices(), kForceSize);
  if (forces_ != BufferId::kInvalid) frame.forces = forces_;
}

Result<void> FieldForces::record(const HairFrame& frame) const {
  if (forces_ == BufferId::kInvalid) return {};
  const ForceField& field = frame.inputs.field;
  const BufferId engine = frame.buffers.forces;
  const bool others = engine != BufferId::kInvalid;
  const auto count = static_cast<uint32_t>(frame.guideVertices());
  ForceFieldConstants constants = {};
  constants.fieldVertexCount = count;
  constants.fieldAddsForces = others ? 1 : 0;
  constants.fieldFirst = field.first;
  constants.fieldKnown = frame.reset ? 0 : 1;
  constants.fieldOrigin = {field.origin.x, field.origin.y, field.origin.z, field.cellSize};
  constants.fieldNodes = {field.nodes[0], field.nodes[1], field.nodes[2], 0};
  const BufferRange positions = {frame.buffers.positions, count * kForceSize};
  PassBuilder builder(frame.list);
  dispatchRows(builder, sampleForceFieldVariant(), count)
      .bytes(count * (others ? 3 : 2) * kForceSize);
  // Positions stand in, and are not read, without forces of others.
  return builder.finish(ForceFieldBindings{
      .forceFieldConstants = constants,
      .fieldPositions = positions,
      .fieldValues = frame.factory.resources.whole(field.values),
      .fieldOthers = others ? BufferRange{engine, count * kForceSize} : positions,
      .fieldForces = {forces_, count * kForceSize},
  });
}

}  // namespace pelage::detail
