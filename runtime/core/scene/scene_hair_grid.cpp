// The passes through which hair touches hair: kernels/simulation/grid.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "simulation/exact_solver.h"

namespace pelage {
namespace {

constexpr uint64_t kVector = sizeof(Float4);
// Nodes an axis, as in the kernels.
constexpr uint32_t kMaxGridSize = 64;
// Nodes beyond the strands' ball: the one after the last cell, one for a ball that begins anywhere
// in a cell, and one for where the bind pose is measured.
constexpr uint32_t kGridBorder = 3;
// Threads of a dispatch in x, as in the kernels.
constexpr uint32_t kRow = 1u << 20;
// The bind pose is measured in this many directions and, in each, with the grid in this many
// places.
constexpr uint32_t kDirections = 4;
constexpr uint32_t kPlaces = 16;
// Largest component of a velocity relative to the whole object [m/s].
constexpr float kMaxSpeed = 16;
// Cells that the front of a pressure of stiffness 1 moves in 1/60 s.
constexpr double kFrontCells = 1;
// A binding's offset is a multiple of this many vectors on every device.
constexpr uint64_t kAlignedVectors = 256 / kVector;

// Where bones put the middle of all strands.
Float3 middleOf(const detail::HairInternals& hair, bool bindPose) {
  double sum[3] = {0, 0, 0};
  for (const detail::BoneBounds& ball : hair.bounds) {
    const AffineTransform bone = bindPose ? AffineTransform{} : hair.bones[ball.bone];
    for (int axis = 0; axis < 3; ++axis) {
      const Float4& row = bone.rows[axis];
      sum[axis] += static_cast<double>(row.x * ball.center.x + row.y * ball.center.y +
                                       row.z * ball.center.z + row.w);
    }
  }
  const auto mean = [&](int axis) {
    return static_cast<float>(sum[axis] / static_cast<double>(hair.bounds.size()));
  };
  return {mean(0), mean(1), mean(2)};
}

// Of the ball around the middle that no strand leaves while the bones move rigidly [m].
double reachOf(const detail::HairInternals& hair) {
  const Float3 middle = middleOf(hair, true);
  double reach = 0;
  for (const detail::BoneBounds& ball : hair.bounds) {
    const double x = static_cast<double>(ball.center.x - middle.x);
    const double y = static_cast<double>(ball.center.y - middle.y);
    const double z = static_cast<double>(ball.center.z - middle.z);
    reach = std::max(reach, std::sqrt(x * x + y * y + z * z) + static_cast<double>(ball.radius));
  }
  return 1.01 * reach + static_cast<double>(hair.longestStrand);
}

// Mass of every vertex as a length of hair [m], the follow hairs' with their guide's; xyz is 0.
std::vector<Float4> massesOf(const HairAsset& asset, const std::vector<uint32_t>& hairs) {
  const size_t stride = asset.verticesPerStrand;
  std::vector<Float4> masses(asset.strandCount * stride);
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    const uint32_t count = detail::vertexCountOf(asset, s);
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
std::vector<Float4> turnedBindPoses(const HairAsset& asset, Float3 middle) {
  // Half a turn of quaternions far from each other and from the grid's axes; the first one is none.
  constexpr double turns[kDirections][4] = {
      {0, 0, 0, 1}, {0.31, 0.17, 0.23, 0.90}, {-0.19, 0.41, 0.11, 0.88}, {0.13, -0.29, 0.47, 0.82}};
  const uint64_t stride = alignedCount(asset.positions.size());
  std::vector<Float4> poses(kDirections * stride);
  for (size_t d = 0; d < kDirections; ++d) {
    const double* q = turns[d];
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

// Places of the grid that fill a cell evenly (additive recurrence of the plastic number's kin, the
// root of x^4 = x + 1).
double placeInCell(uint32_t place, int axis) {
  const double step = std::pow(1.2207440846057596, -(axis + 1));
  const double at = 0.5 + place * step;
  return at - std::floor(at);
}

float powerOfTwoBelow(double x) { return static_cast<float>(std::exp2(std::floor(std::log2(x)))); }

bool isOn(const HairContactSettings& contact) {
  return contact.stiffness > 0 || contact.friction > 0;
}

// An object as the passes see it.
struct GridObject {
  const HairBuffers& buffers;
  const detail::HairInternals& internals;
  uint32_t vertices;  ///< of all guides
};

// What all kernels of the grid take: the grid around a middle.
// \param shifted of the middle's space: nodes stay where they are in the first world
HairGridConstants constantsOf(const GridObject& object, Float3 middle,
                              const detail::Vector3<double>& shifted) {
  const detail::HairGrid& grid = object.internals.grid;
  const double cell = static_cast<double>(grid.cell);
  const double reach = 0.5 * cell * (grid.size - kGridBorder);
  // To whole cells, so that hair at rest sees the same density wherever a little motion puts it.
  const auto lowest = [&](float m, double shift) {
    const double at = static_cast<double>(m) + shift;
    return static_cast<float>(std::floor((at - reach) / cell) * cell - shift);
  };
  HairGridConstants constants = {};
  constants.gridOrigin = {lowest(middle.x, shifted.x), lowest(middle.y, shifted.y),
                          lowest(middle.z, shifted.z), grid.cell};
  constants.gridVelocity = {0, 0, 0, kMaxSpeed};
  constants.massScale = grid.massScale;
  constants.momentumScale = grid.momentumScale;
  constants.gridSize = grid.size;
  constants.gridVertexCount = object.vertices;
  return constants;
}

// Clears the grid and adds the vertices to it.
Result<void> addSplatPasses(const GridObject& object, const HairGridConstants& constants,
                            BufferId positions, uint64_t offset, PassList& list) {
  const HairBuffers& buffers = object.buffers;
  const uint32_t count = constants.gridVertexCount;
  const uint64_t nodes = uint64_t{constants.gridSize} * constants.gridSize * constants.gridSize;
  const uint32_t channels = constants.gridFriction != 0 ? 4 : 1;
  const uint64_t nodeBytes = nodes * channels * sizeof(uint32_t);
  const uint64_t lanes = uint64_t{count} * 2 * channels;
  PassBuilder clear(list);
  clear.dispatch(clearHairGridVariant({}), static_cast<uint32_t>(nodes) * channels)
      .bind("g_gridNodes", buffers.contactNodes, nodeBytes)
      .constants("HairGridConstants", constants)
      .bytes(nodeBytes);
  if (Result<void> added = clear.finish(); !added) return added;
  PassBuilder splat(list);
  splat
      .dispatch(splatHairGridVariant({}), static_cast<uint32_t>(std::min<uint64_t>(lanes, kRow)),
                static_cast<uint32_t>((lanes + kRow - 1) / kRow))
      .bind("g_gridPositions", positions, count * kVector, offset)
      .bind("g_gridBefore", buffers.contactVertices, count * kVector)
      .bind("g_gridNodes", buffers.contactNodes, nodeBytes)
      .constants("HairGridConstants", constants)
      .bytes(2 * count * kVector + nodeBytes);
  return splat.finish();
}

// The rest density of every vertex, once for a grid.
Result<void> addMeasurePasses(const GridObject& object, PassList& list) {
  const detail::HairInternals& internals = object.internals;
  const HairBuffers& buffers = object.buffers;
  HairGridConstants constants = constantsOf(object, middleOf(internals, true), {});
  const uint64_t count = constants.gridVertexCount;
  const uint64_t nodes = uint64_t{constants.gridSize} * constants.gridSize * constants.gridSize;
  const Float4 origin = constants.gridOrigin;
  for (uint32_t direction = 0; direction < kDirections; ++direction) {
    const uint64_t offset = direction * alignedCount(count) * kVector;
    for (uint32_t place = 0; place < kPlaces; ++place) {
      const auto moved = [&](float from, int axis) {
        return from - static_cast<float>(placeInCell(place, axis)) * origin.w;
      };
      constants.gridOrigin = {moved(origin.x, 0), moved(origin.y, 1), moved(origin.z, 2), origin.w};
      const BufferId poses = internals.grid.bindPoses;
      if (Result<void> added = addSplatPasses(object, constants, poses, offset, list); !added)
        return added;
      PassBuilder builder(list);
      const auto threads = static_cast<uint32_t>(count);
      builder
          .dispatch(measureHairGridVariant({}), std::min(threads, kRow),
                    (threads + kRow - 1) / kRow)
          .bind("g_gridPositions", poses, count * kVector, offset)
          .bind("g_gridBefore", buffers.contactVertices, count * kVector)
          .bind("g_gridRest", buffers.contactRest, count * sizeof(float))
          .bind("g_gridNodes", buffers.contactNodes, nodes * sizeof(uint32_t))
          .constants("HairGridConstants", constants)
          .bytes(count * (2 * kVector + 2 * sizeof(float)) + nodes * sizeof(uint32_t));
      if (Result<void> added = builder.finish(); !added) return added;
    }
  }
  return {};
}

}  // namespace

BufferId Scene::forcesOf(const HairObject& object) const {
  const BufferId ofContact = object.buffers_.contactForces;
  return ofContact != BufferId::kInvalid ? ofContact : object.buffers_.forces;
}

void Scene::removeHairGrid(HairObject& object) {
  HairBuffers& buffers = object.buffers_;
  for (BufferId* buffer : {&buffers.contactNodes, &buffers.contactVertices, &buffers.contactRest,
                           &buffers.contactForces, &object.internals_->grid.bindPoses})
    removeBuffer(*buffer);
  object.internals_->grid = {};
}

void Scene::addHairGrid(HairObject& object) {
  detail::HairInternals& internals = *object.internals_;
  detail::HairGrid& grid = internals.grid;
  const HairContactSettings& contact = object.settings.contact;
  removeBuffer(grid.bindPoses);
  const bool on = object.settings.solver == Solver::kExact && isOn(contact);
  const bool same = grid.size > 0 && grid.cellSetting == contact.cellSize &&
                    grid.friction == (contact.friction > 0) &&
                    grid.pressure == (contact.stiffness > 0);
  if (on && same) return;
  removeHairGrid(object);
  if (!on) return;

  const double reach = reachOf(internals);
  const double cell =
      std::max(static_cast<double>(contact.cellSize), 2 * reach / (kMaxGridSize - kGridBorder - 1));
  grid.cellSetting = contact.cellSize;
  grid.cell = static_cast<float>(cell);
  grid.size =
      static_cast<uint32_t>(std::ceil(2 * reach / static_cast<double>(grid.cell))) + kGridBorder;
  grid.friction = contact.friction > 0;
  grid.pressure = contact.stiffness > 0;

  const HairAsset& asset = internals.asset;
  const std::vector<Float4> masses = massesOf(asset, internals.hairsOfGuides);
  double total = 0;
  for (const Float4& vertex : masses) total += static_cast<double>(vertex.w);
  // Powers of two: they do not depend on the order of the sum, and products with them are exact.
  grid.massScale = powerOfTwoBelow(std::min(0x1p31 / total, 0x1p100));
  grid.momentumScale = grid.massScale / (2 * kMaxSpeed);

  HairBuffers& buffers = object.buffers_;
  const auto add = [&](const char* what, uint64_t count, uint32_t stride,
                       std::span<const Float4> initial = {}) {
    const auto bytes = std::as_bytes(initial);
    return resources_.add({.name = object.name_ + "/" + what,
                           .size = count * stride,
                           .stride = stride,
                           .initial = {bytes.begin(), bytes.end()}});
  };
  const uint64_t nodes = uint64_t{grid.size} * grid.size * grid.size;
  buffers.contactNodes = add("contactNodes", nodes * (grid.friction ? 4 : 1), sizeof(uint32_t));
  buffers.contactVertices = add("contactVertices", masses.size(), kVector, masses);
  buffers.contactForces = add("contactForces", masses.size(), kVector);
  if (grid.pressure) {
    buffers.contactRest = add("contactRest", masses.size(), sizeof(float));
    const std::vector<Float4> poses = turnedBindPoses(asset, middleOf(internals, true));
    grid.bindPoses = add("contactBindPoses", poses.size(), kVector, poses);
  }
}

Result<void> Scene::addHairGridPasses(HairObject& object, double h, bool reset, PassList& list) {
  detail::HairInternals& internals = *object.internals_;
  detail::HairGrid& grid = internals.grid;
  if (grid.size == 0) return {};
  const HairBuffers& buffers = object.buffers_;
  const HairContactSettings& contact = object.settings.contact;
  const GridObject view = {buffers, internals, object.guideCount_ * object.vertexCount_};
  if (grid.bindPoses != BufferId::kInvalid && !grid.measured) {
    if (Result<void> added = addMeasurePasses(view, list); !added) return added;
    grid.measured = true;
  }
  const Float3 middle = middleOf(internals, false);
  const bool finite = std::isfinite(middle.x) && std::isfinite(middle.y) && std::isfinite(middle.z);
  HairGridConstants constants =
      constantsOf(view, finite ? middle : grid.middle, internals.origin.shifted);
  if (reset) grid.history = 0;
  // There are positions from the second step on, and velocities from the third one on.
  if (grid.history > 1) {
    constants.gridVelocity.x = grid.velocity.x;
    constants.gridVelocity.y = grid.velocity.y;
    constants.gridVelocity.z = grid.velocity.z;
    constants.inverseStep = static_cast<float>(1 / grid.step);
    constants.lookAhead = static_cast<float>(h);
  }
  constants.pressure =
      static_cast<float>(static_cast<double>(contact.stiffness) *
                         std::pow(kFrontCells * static_cast<double>(grid.cell) * 60, 2));
  constants.gridFriction = grid.friction ? 1 : 0;
  constants.frictionRate =
      static_cast<float>((1 - std::pow(1 - static_cast<double>(contact.friction), 60 * h)) / h);
  if (grid.history == 0) {
    // Nothing is inside a grid without nodes: the pass clears the forces.
    constants.gridSize = 0;
  } else if (Result<void> added = addSplatPasses(view, constants, buffers.positions, 0, list);
             !added) {
    return added;
  }
  const uint64_t count = constants.gridVertexCount;
  const uint64_t nodes = uint64_t{grid.size} * grid.size * grid.size;
  const uint64_t nodeBytes = nodes * (grid.friction ? 4 : 1) * sizeof(uint32_t);
  const bool others = buffers.forces != BufferId::kInvalid;
  constants.addsForces = others ? 1 : 0;
  const auto threads = static_cast<uint32_t>(count);
  PassBuilder builder(list);
  builder.dispatch(applyHairGridVariant({}), std::min(threads, kRow), (threads + kRow - 1) / kRow)
      .bind("g_gridPositions", buffers.positions, count * kVector)
      .bind("g_otherForces", buffers.forces, count * kVector)
      .bind("g_gridBefore", buffers.contactVertices, count * kVector)
      .bind("g_gridRest", buffers.contactRest, count * sizeof(float))
      // Stand-ins that are not read, without pressure and without forces of others.
      .bind("g_gridRest", buffers.positions, count * kVector)
      .bind("g_otherForces", buffers.positions, count * kVector)
      .bind("g_gridNodes", buffers.contactNodes, nodeBytes)
      .bind("g_gridForces", buffers.contactForces, count * kVector)
      .constants("HairGridConstants", constants)
      .bytes(count * (4 * kVector + (grid.pressure ? sizeof(float) : 0) + (others ? kVector : 0)) +
             nodeBytes);
  grid.history = std::min(grid.history + 1, 2u);
  grid.step = h;
  return builder.finish();
}

void Scene::finishHairGrid(HairObject& object, double frame) {
  detail::HairInternals& internals = *object.internals_;
  detail::HairGrid& grid = internals.grid;
  if (grid.size == 0) return;
  const Float3 middle = middleOf(internals, false);
  const auto speed = [&](float now, float before) {
    const double v = (static_cast<double>(now) - static_cast<double>(before)) / frame;
    return std::isfinite(v) ? static_cast<float>(v) : 0.0f;
  };
  grid.velocity = {speed(middle.x, grid.middle.x), speed(middle.y, grid.middle.y),
                   speed(middle.z, grid.middle.z)};
  if (std::isfinite(middle.x) && std::isfinite(middle.y) && std::isfinite(middle.z))
    grid.middle = middle;
}

}  // namespace pelage
