#include "contact/hair_grid.h"

#include <algorithm>
#include <cmath>

#include "base/finite.h"
#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

// Nodes beyond the strands' ball: the one after the last cell, one for a ball that begins
// anywhere in a cell, and one for where the bind pose is measured.
constexpr uint32_t kGridBorder = 3;
// The bind pose is measured in this many directions and, in each, with the grid in this many
// places.
constexpr uint32_t kDirections = 4;
constexpr uint32_t kPoints = 16;
// Largest component of a velocity relative to the whole object [m/s].
constexpr float kMaxSpeed = 16;
// Cells that the front of a pressure of stiffness 1 moves in 1/60 s.
constexpr double kFrontCells = 1;
// A binding's offset is a multiple of this many vectors on every device.
constexpr uint64_t kAlignedVectors = 256 / kVector;

// Radius around the middle that no strand leaves while the bones move rigidly [m].
double extentOf(const HairInputs& hair) {
  const Float3 middle = middleOf(hair.bounds, {});
  double extent = 0;
  for (const BoneBounds& ball : hair.bounds) {
    const double x = static_cast<double>(ball.center.x - middle.x);
    const double y = static_cast<double>(ball.center.y - middle.y);
    const double z = static_cast<double>(ball.center.z - middle.z);
    extent = std::max(extent, std::sqrt(x * x + y * y + z * z) + static_cast<double>(ball.radius));
  }
  return 1.01 * extent + static_cast<double>(hair.rest.longestStrand) +
         static_cast<double>(hair.deviation);
}

// Mass of every vertex as a length of hair [m], the follow hairs' with their guide's; xyz is 0.
std::vector<Float4> massesOf(const HairAsset& asset, const std::vector<uint32_t>& hairs) {
  const size_t stride = asset.verticesPerStrand;
  std::vector<Float4> masses(asset.strandCount * stride);
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const uint32_t count = vertexCountOf(asset, s);
    for (size_t i = 0; i < count; ++i) {
      const size_t at = s * stride + i;
      const float before = i > 0 ? asset.restLengths[at - 1] : 0;
      const float after = i + 1 < count ? asset.restLengths[at] : 0;
      masses[at].w = 0.5f * (before + after) * static_cast<float>(hairs[s]);
    }
  }
  return masses;
}

// Vectors from one direction of the bind pose to the next one.
uint64_t alignedCount(uint64_t vertices) {
  return (vertices + kAlignedVectors - 1) / kAlignedVectors * kAlignedVectors;
}

// The bind pose, turned about its middle in several directions.
std::vector<Float4> rotatedBindPoses(const HairAsset& asset, Float3 middle) {
  // Half a turn of quaternions far from each other and from the grid's axes; the first one is
  // none.
  constexpr double kRotations[kDirections][4] = {
      {0, 0, 0, 1}, {0.31, 0.17, 0.23, 0.90}, {-0.19, 0.41, 0.11, 0.88}, {0.13, -0.29, 0.47, 0.82}};
  const uint64_t stride = alignedCount(asset.positions.size());
  std::vector<Float4> poses(kDirections * stride);
  for (size_t d = 0; d < kDirections; ++d) {
    const double* q = kRotations[d];
    const double scale = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (size_t i = 0; i < asset.positions.size(); ++i) {
      const Float4& p = asset.positions[i];
      const double v[3] = {static_cast<double>(p.x - middle.x), static_cast<double>(p.y - middle.y),
                           static_cast<double>(p.z - middle.z)};
      const auto cross = [&](const double* a, int axis) {
        const int j = (axis + 1) % 3, k = (axis + 2) % 3;
        return q[j] * a[k] - q[k] * a[j];
      };
      const double c[3] = {cross(v, 0), cross(v, 1), cross(v, 2)};
      double r[3];
      for (int axis = 0; axis < 3; ++axis)
        r[axis] = v[axis] + scale * (q[3] * c[axis] + cross(c, axis));
      poses[d * stride + i] = {static_cast<float>(r[0]) + middle.x,
                               static_cast<float>(r[1]) + middle.y,
                               static_cast<float>(r[2]) + middle.z, 0};
    }
  }
  return poses;
}

// Places of the grid that fill a cell evenly (additive recurrence of the plastic number's kin,
// the root of x^4 = x + 1).
double slotInCell(uint32_t slot, int axis) {
  const double step = std::pow(1.2207440846057596, -(axis + 1));
  const double at = 0.5 + slot * step;
  return at - std::floor(at);
}

float powerOfTwoBelow(double x) { return static_cast<float>(std::exp2(std::floor(std::log2(x)))); }

bool isOn(const HairContactSettings& contact) {
  return contact.stiffness > 0 || contact.friction > 0;
}

// Constants of all kernels of the grid: the grid around a middle.
// \param shifted of the middle's space: nodes stay where they are in the first world
HairGridConstants constantsOf(const GridShape& shape, const HairFrame& frame, Float3 middle,
                              const Vector3<double>& shifted) {
  const double cell = static_cast<double>(shape.cell);
  const double extent = 0.5 * cell * (shape.size - kGridBorder);
  // To whole cells, so that hair at rest sees the same density wherever a little motion puts it.
  const auto lowest = [&](float m, double shift) {
    const double at = static_cast<double>(m) + shift;
    return static_cast<float>(std::floor((at - extent) / cell) * cell - shift);
  };
  HairGridConstants constants = {};
  constants.gridOrigin = {lowest(middle.x, shifted.x), lowest(middle.y, shifted.y),
                          lowest(middle.z, shifted.z), shape.cell};
  constants.gridVelocity = {0, 0, 0, kMaxSpeed};
  constants.massScale = shape.massScale;
  constants.momentumScale = shape.momentumScale;
  constants.gridSize = shape.size;
  constants.gridVertexCount = static_cast<uint32_t>(frame.inputs.rest.asset->positions.size());
  return constants;
}

// Clears the grid and adds the vertices to it.
Result<void> addSplatPasses(const HairGridConstants& constants, const GridBuffers& buffers,
                            BufferId positions, uint64_t offset, PassList& list) {
  const uint32_t count = constants.gridVertexCount;
  const uint64_t nodes = uint64_t{constants.gridSize} * constants.gridSize * constants.gridSize;
  const uint32_t channels = constants.gridFriction != 0 ? 4 : 1;
  const uint64_t nodeBytes = nodes * channels * sizeof(uint32_t);
  const uint64_t lanes = uint64_t{count} * 2 * channels;
  PassBuilder clear(list);
  clear.dispatch(clearHairGridVariant({}), static_cast<uint32_t>(nodes) * channels)
      .bytes(nodeBytes);
  if (Result<void> added = clear.finish(HairGridBindings{
          .hairGridConstants = constants,
          .gridNodes = {buffers.nodes, nodeBytes},
      });
      !added)
    return added;
  PassBuilder splat(list);
  dispatchRows(splat, splatHairGridVariant({}), lanes).bytes(2 * count * kVector + nodeBytes);
  return splat.finish(HairGridBindings{
      .hairGridConstants = constants,
      .gridPositions = {positions, count * kVector, offset},
      .gridBefore = {buffers.vertices, count * kVector},
      .gridNodes = {buffers.nodes, nodeBytes},
  });
}

// The rest density of every vertex, once for a grid.
Result<void> addMeasurePasses(const GridShape& shape, const GridBuffers& buffers,
                              const HairFrame& frame) {
  PassList& list = frame.list;
  HairGridConstants constants = constantsOf(shape, frame, middleOf(frame.inputs.bounds, {}), {});
  const uint64_t count = constants.gridVertexCount;
  const Float4 origin = constants.gridOrigin;
  for (uint32_t direction = 0; direction < kDirections; ++direction) {
    const uint64_t offset = direction * alignedCount(count) * kVector;
    for (uint32_t slot = 0; slot < kPoints; ++slot) {
      const auto moved = [&](float from, int axis) {
        return from - static_cast<float>(slotInCell(slot, axis)) * origin.w;
      };
      constants.gridOrigin = {moved(origin.x, 0), moved(origin.y, 1), moved(origin.z, 2), origin.w};
      if (Result<void> added = addSplatPasses(constants, buffers, buffers.bindPoses, offset, list);
          !added)
        return added;
      PassBuilder builder(list);
      dispatchRows(builder, measureHairGridVariant({}), count)
          .bytes(count * (2 * kVector + 2 * sizeof(float)) + shape.nodes() * sizeof(uint32_t));
      if (Result<void> added = builder.finish(HairGridBindings{
              .hairGridConstants = constants,
              .gridPositions = {buffers.bindPoses, count * kVector, offset},
              .gridBefore = {buffers.vertices, count * kVector},
              .gridRest = {buffers.rest, count * sizeof(float)},
              .gridNodes = {buffers.nodes, shape.nodes() * sizeof(uint32_t)},
          });
          !added)
        return added;
    }
  }
  return {};
}

}  // namespace

void HairGrid::remove(const BufferFactory& factory) {
  for (BufferId* buffer :
       {&buffers_.nodes, &buffers_.vertices, &buffers_.rest, &buffers_.forces, &buffers_.bindPoses})
    factory.remove(*buffer);
  *this = {};
}

void HairGrid::prepare(HairFrame& frame) {
  if (frame.mode == FrameMode::kPose) return;
  const HairContactSettings& contact = frame.settings.contact;
  const BufferFactory& factory = frame.factory;
  const bool on = frame.mode == FrameMode::kSimulate && frame.settings.solver == Solver::kExact &&
                  isOn(contact);
  factory.remove(buffers_.bindPoses);
  const bool same = !frame.otherRest && shape_.size > 0 && shape_.cellSetting == contact.cellSize &&
                    shape_.friction == (contact.friction > 0) &&
                    shape_.pressure == (contact.stiffness > 0);
  if (!on || !same) remove(factory);
  if (on && !same) make(frame);
  frame.buffers.contactForces = buffers_.forces;
  others_ = frame.forces;
  if (on) frame.forces = buffers_.forces;
}

void HairGrid::make(const HairFrame& frame) {
  const HairContactSettings& contact = frame.settings.contact;
  const double extent = extentOf(frame.inputs);
  const double cell = std::max(static_cast<double>(contact.cellSize),
                               2 * extent / (hair_grid::kMaxGridSize - kGridBorder - 1));
  shape_.cellSetting = contact.cellSize;
  shape_.cell = static_cast<float>(cell);
  shape_.size =
      static_cast<uint32_t>(std::ceil(2 * extent / static_cast<double>(shape_.cell))) + kGridBorder;
  shape_.friction = contact.friction > 0;
  shape_.pressure = contact.stiffness > 0;

  const HairAsset& asset = *frame.inputs.rest.asset;
  const std::vector<Float4> masses = massesOf(asset, frame.groom.hairsOfGuides);
  double total = 0;
  for (const Float4& vertex : masses) total += static_cast<double>(vertex.w);
  // Powers of two: they do not depend on the order of the sum, and products with them are exact.
  shape_.massScale = powerOfTwoBelow(std::min(0x1p31 / total, 0x1p100));
  shape_.momentumScale = shape_.massScale / (2 * kMaxSpeed);

  const auto add = [&](const char* what, uint64_t count, uint32_t stride,
                       std::span<const Float4> initial = {}) {
    const auto bytes = std::as_bytes(initial);
    return frame.factory.add(frame.name + "/" + what, count, stride, {bytes.begin(), bytes.end()});
  };
  buffers_.nodes =
      add("contactNodes", shape_.nodes() * (shape_.friction ? 4 : 1), sizeof(uint32_t));
  buffers_.vertices = add("contactVertices", masses.size(), kVector, masses);
  buffers_.forces = add("contactForces", masses.size(), kVector);
  if (shape_.pressure) {
    buffers_.rest = add("contactRest", masses.size(), sizeof(float));
    const std::vector<Float4> poses = rotatedBindPoses(asset, middleOf(frame.inputs.bounds, {}));
    buffers_.bindPoses = add("contactBindPoses", poses.size(), kVector, poses);
  }
}

Result<void> HairGrid::record(const HairFrame& frame, double h, bool reset) {
  if (shape_.size == 0) return {};
  PassList& list = frame.list;
  const HairContactSettings& contact = frame.settings.contact;
  if (buffers_.bindPoses != BufferId::kInvalid && !measured_) {
    if (Result<void> added = addMeasurePasses(shape_, buffers_, frame); !added) return added;
    measured_ = true;
  }
  const Float3 middle = middleOf(frame.inputs.bounds, frame.inputs.bones);
  const bool finite = isFinite(middle);
  HairGridConstants constants =
      constantsOf(shape_, frame, finite ? middle : middle_, frame.origin.shifted);
  if (reset) history_ = 0;
  // There are positions from the second step on, and velocities from the third one on.
  if (history_ > 1) {
    constants.gridVelocity.x = velocity_.x;
    constants.gridVelocity.y = velocity_.y;
    constants.gridVelocity.z = velocity_.z;
    constants.inverseStep = static_cast<float>(1 / step_);
    constants.lookAhead = static_cast<float>(h);
  }
  constants.pressure =
      static_cast<float>(static_cast<double>(contact.stiffness) *
                         std::pow(kFrontCells * static_cast<double>(shape_.cell) * 60, 2));
  constants.gridFriction = shape_.friction ? 1 : 0;
  constants.frictionRate =
      static_cast<float>((1 - std::pow(1 - static_cast<double>(contact.friction), 60 * h)) / h);
  if (history_ == 0) {
    // Nothing is inside a grid without nodes: the pass clears the forces.
    constants.gridSize = 0;
  } else if (Result<void> added =
                 addSplatPasses(constants, buffers_, frame.buffers.positions, 0, list);
             !added) {
    return added;
  }
  const uint64_t count = constants.gridVertexCount;
  const uint64_t nodeBytes = shape_.nodes() * (shape_.friction ? 4 : 1) * sizeof(uint32_t);
  const bool others = others_ != BufferId::kInvalid;
  constants.addsForces = others ? 1 : 0;
  PassBuilder builder(list);
  dispatchRows(builder, applyHairGridVariant({}), count)
      .bytes(count *
                 (4 * kVector + (shape_.pressure ? sizeof(float) : 0) + (others ? kVector : 0)) +
             nodeBytes);
  history_ = std::min(history_ + 1, 2u);
  step_ = h;
  const BufferRange positions = {frame.buffers.positions, count * kVector};
  const BufferRange rest = {buffers_.rest, count * sizeof(float)};
  // Positions stand in, and are not read, without pressure and without forces of others.
  return builder.finish(HairGridBindings{
      .hairGridConstants = constants,
      .gridPositions = positions,
      .otherForces = others ? BufferRange{others_, count * kVector} : positions,
      .gridBefore = {buffers_.vertices, count * kVector},
      .gridRest = rest.isBound() ? rest : positions,
      .gridNodes = {buffers_.nodes, nodeBytes},
      .gridForces = {buffers_.forces, count * kVector},
  });
}

void HairGrid::finish(const HairFrame& frame) {
  if (shape_.size == 0) return;
  const auto seconds = static_cast<double>(frame.length);
  const Float3 middle = middleOf(frame.inputs.bounds, frame.inputs.bones);
  const auto speed = [&](float now, float before) {
    const double v = (static_cast<double>(now) - static_cast<double>(before)) / seconds;
    return std::isfinite(v) ? static_cast<float>(v) : 0.0f;
  };
  velocity_ = {speed(middle.x, middle_.x), speed(middle.y, middle_.y), speed(middle.z, middle_.z)};
  if (isFinite(middle)) middle_ = middle;
}

}  // namespace pelage::detail
