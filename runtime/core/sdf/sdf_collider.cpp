#include "sdf/sdf_collider.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "base/finite.h"
#include "base/vector3.h"
#include "pelage/assert.h"
#include "pelage/constants.h"
#include "pelage/skeleton.h"
#include "sdf/dense_sdf.h"

namespace pelage {
namespace detail {
namespace {

Float3 corner(const Box& box, uint32_t index) {
  return {(index & 1) != 0 ? box.high.x : box.low.x, (index & 2) != 0 ? box.high.y : box.low.y,
          (index & 4) != 0 ? box.high.z : box.low.z};
}

// Slack around a moving mesh, so that not every frame needs a new grid [cells].
constexpr float kRoomCells = 2;
// A grid is too large if it has more nodes than this factor times those of a new one.
constexpr double kMostWaste = 3;

Box relativeTo(const LocalOrigin& origin, const Box& box) {
  return {origin.relative(box.low), origin.relative(box.high)};
}

// Box around the nodes of data, in the current world.
Box boxOfData(const SdfColliderInternals& collider) {
  const SdfGrid& grid = collider.data->grid;
  const auto last = [&](size_t axis) {
    return static_cast<double>(grid.nodes[axis] - 1) * static_cast<double>(grid.cellSize);
  };
  const LocalOrigin& origin = collider.origin;
  const Vector3<double> low = collider.dataNode + (origin.metres - origin.shifted);
  return {toFloat3(low), toFloat3(low + Vector3<double>{last(0), last(1), last(2)})};
}

// A point of a box moves at most as far as one of its corners.
// \param move  displacement that does not count
float largestDisplacement(const BoneBox& bone, const AffineTransform& from,
                          const AffineTransform& to, const AffineTransform& move = {}) {
  float largest = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    const Float3 p = corner(bone.box, i);
    const Float3 a = transformPoint(move, transformPoint(from, p)), b = transformPoint(to, p);
    const Float3 displacement = {b.x - a.x, b.y - a.y, b.z - a.z};
    const float distance =
        std::sqrt(displacement.x * displacement.x + displacement.y * displacement.y +
                  displacement.z * displacement.z);
    // A NaN counts as far.
    if (!(distance <= largest)) largest = distance;
  }
  return std::isnan(largest) ? std::numeric_limits<float>::infinity() : largest;
}

}  // namespace

LocalOrigin originFor(const SdfColliderInternals& collider) {
  if (collider.skeleton != nullptr) return collider.skeleton->origin;
  const Box box = boundsOf(collider);
  // An engine's vertices are relative to the world's own origin.
  if (collider.def.vertices != BufferId::kInvalid) return collider.origin.near({});
  if (box.isEmpty() || !isFinite(box)) return collider.origin;
  const Float3 middle = middleOf(box);
  const Float3 away = collider.origin.relative(middle);
  LocalOrigin origin = collider.origin.near(middle);
  if (std::abs(away.x) <= kOriginRange) origin.metres.x = collider.origin.metres.x;
  if (std::abs(away.y) <= kOriginRange) origin.metres.y = collider.origin.metres.y;
  if (std::abs(away.z) <= kOriginRange) origin.metres.z = collider.origin.metres.z;
  return origin;
}

SdfGrid gridOf(const SdfColliderInternals& collider) {
  if (collider.dense) return collider.dense->grid;
  if (collider.data) {
    SdfGrid grid = collider.data->grid;
    grid.origin = boxOfData(collider).low;
    return grid;
  }
  const SdfGridPlan& plan = collider.plan;
  return {.origin = collider.origin.toWorld(plan.origin),
          .cellSize = plan.cellSize,
          .nodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2]}};
}

void shiftWorld(SdfColliderInternals& collider, const Vector3<double>& shift,
                const Vector3<double>& shifted) {
  shiftWorld(static_cast<SdfFrameState&>(collider), shift, shifted);
  ShiftedFloats& floats = collider.shiftedInputs;
  floats.begin();
  for (AffineTransform& bone : collider.bones) floats.shift(bone, -shift);
  if (collider.data) {
    collider.vertexBounds = boxOfData(collider);
  } else if (collider.dense) {
    floats.shift(collider.dense->grid.origin, -shift);
    collider.vertexBounds = boxOf(collider.dense->grid);
  } else if (!collider.vertexBounds.isEmpty()) {
    floats.shift(collider.vertexBounds.low, -shift);
    floats.shift(collider.vertexBounds.high, -shift);
  }
  floats.end();
  if (!collider.hasMesh()) collider.grid = gridOf(collider);
}

void shiftWorld(SdfFrameState& state, const Vector3<double>& shift,
                const Vector3<double>& shifted) {
  state.origin.shifted = shifted;
  state.shiftedFloats.begin();
  for (AffineTransform& bone : state.builtBones) state.shiftedFloats.shift(bone, -shift);
  state.shiftedFloats.end();
  if (state.plan.cellSize > 0) state.grid.origin = state.origin.toWorld(state.plan.origin);
}

HostArray<BoneBox> boneBoxesOf(const CollisionMesh& mesh) {
  HostArray<BoneBox> boxes;
  const auto add = [&](uint32_t bone, const Float3& p) {
    if (bone >= boxes.size()) boxes.resize(size_t{bone} + 1);
    boxes[bone].bone = bone;
    boxes[bone].box = include(boxes[bone].box, p);
    ++boxes[bone].vertexCount;
  };
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    bool bound = false;
    for (size_t k = 0; k < 4 && v < mesh.influences.size(); ++k) {
      if (!(mesh.influences[v].weights[k] > 0)) continue;
      add(mesh.influences[v].bones[k], mesh.positions[v]);
      bound = true;
    }
    if (!bound)
      add(v < mesh.influences.size() ? mesh.influences[v].bones[0] : 0, mesh.positions[v]);
  }
  std::erase_if(boxes, [](const BoneBox& box) { return box.box.isEmpty(); });
  return boxes;
}

HostArray<BoneBox> boxOfAll(const CollisionMesh& mesh) {
  BoneBox all;
  for (const Float3& p : mesh.positions) all.box = include(all.box, p);
  all.vertexCount = static_cast<uint32_t>(mesh.positions.size());
  return {all};
}

uint32_t boneCountOf(const SdfColliderInternals& collider) {
  return collider.skeleton != nullptr ? collider.skeleton->boneCount
                                      : static_cast<uint32_t>(collider.bones.size());
}

Box boundsOf(const SdfColliderInternals& collider) {
  if (!collider.hasMesh() || collider.def.vertices != BufferId::kInvalid)
    return collider.vertexBounds;
  Box all;
  for (const BoneBox& bone : collider.boneBoxes) {
    Box box;
    for (uint32_t i = 0; i < 8; ++i)
      box = include(box, transformPoint(collider.bones[bone.bone], corner(bone.box, i)));
    if (isFinite(box)) all = include(all, box);
  }
  if (collider.skeleton == nullptr || all.isEmpty()) return all;
  const float deviation = collider.skeleton->deviation;
  return {{all.low.x - deviation, all.low.y - deviation, all.low.z - deviation},
          {all.high.x + deviation, all.high.y + deviation, all.high.z + deviation}};
}

bool isMirrored(const SdfColliderInternals& collider) {
  const bool blends = collider.def.vertices == BufferId::kInvalid &&
                      collider.def.skinning == SkinningMethod::kMatrices;
  if (!blends || collider.boneBoxes.empty()) return false;
  return std::all_of(collider.boneBoxes.begin(), collider.boneBoxes.end(), [&](const BoneBox& box) {
    const Float4* r = collider.bones[box.bone].rows;
    const auto minor = [&](float Float4::*i, float Float4::*j) {
      return double{r[1].*i} * double{r[2].*j} - double{r[1].*j} * double{r[2].*i};
    };
    return double{r[0].x} * minor(&Float4::y, &Float4::z) -
               double{r[0].y} * minor(&Float4::x, &Float4::z) +
               double{r[0].z} * minor(&Float4::x, &Float4::y) <
           0;
  });
}

Result<void> checkSdfColliderDef(const SdfColliderDef& def) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, what};
  };
  if (!std::isfinite(def.cellSize) || def.cellSize < 0)
    return refuse("cellSize is " + std::to_string(def.cellSize) +
                  ", but must be finite and at least 0");
  if (!(def.band >= 1 && def.band <= 8))
    return refuse("band is " + std::to_string(def.band) + ", but must be in 1..8");
  if (!(def.motionTolerance >= 0 && def.motionTolerance <= 1))
    return refuse("motionTolerance is " + std::to_string(def.motionTolerance) +
                  ", but must be in 0..1");
  if (def.boneCount == 0) return refuse("boneCount must be at least 1");
  if (def.vertexStride < 3)
    return refuse("vertexStride is " + std::to_string(def.vertexStride) +
                  ", but a position has 3 floats");
  return {};
}

Result<std::optional<SdfGridPlan>> planGrid(const SdfColliderInternals& collider) {
  const Box box = boundsOf(collider);
  const bool planned = collider.plan.cellSize > 0;
  // Invalid bounds leave the grid where it was.
  if (!isFinite(box) || (box.isEmpty() && planned)) return std::optional<SdfGridPlan>();
  const SdfColliderDef& def = collider.def;
  const float ring = (def.band + 1) * def.cellSize;
  if (planned) {
    const SdfGridPlan& plan = collider.plan;
    const auto end = [&](float origin, uint32_t nodes) {
      return origin + static_cast<float>(nodes - 1) * plan.cellSize;
    };
    const Box grid = {plan.origin,
                      {end(plan.origin.x, plan.nodes[0]), end(plan.origin.y, plan.nodes[1]),
                       end(plan.origin.z, plan.nodes[2])}};
    const Box relative = relativeTo(collider.origin, box);
    const auto size = [&](const Box& b) {
      return static_cast<double>(b.high.x - b.low.x + 2 * ring) *
             static_cast<double>(b.high.y - b.low.y + 2 * ring) *
             static_cast<double>(b.high.z - b.low.z + 2 * ring);
    };
    const double cell = static_cast<double>(plan.cellSize);
    const bool wasteful =
        static_cast<double>(plan.nodeCount()) * cell * cell * cell > kMostWaste * size(relative);
    const bool originMoved =
        collider.skeleton != nullptr && !collider.skeleton->origin.isAt(collider.origin);
    // If vertices within the tolerance keep their positions, the grid does, too.
    const float margin = ring - def.motionTolerance * plan.cellSize;
    if (isInside(relative, grid, margin) && !wasteful && !originMoved)
      return std::optional<SdfGridPlan>();
  }
  SdfGridDef grid;
  grid.lowest = {0, 0, 0};
  grid.highest = {-1, -1, -1};
  if (!box.isEmpty()) {
    // Slack from the second grid on.
    const float room = planned ? kRoomCells * def.cellSize : 0;
    const Box relative = relativeTo(originFor(collider), box);
    grid.lowest = {relative.low.x - room, relative.low.y - room, relative.low.z - room};
    grid.highest = {relative.high.x + room, relative.high.y + room, relative.high.z + room};
  }
  grid.cellSize = def.cellSize;
  grid.band = def.band;
  grid.triangleCount = collider.topology.triangleCount();
  grid.threeAxes = !collider.topology.isSolid();
  grid.memoryCap = def.memoryCap;
  Result<SdfGridPlan> plan = planSdfGrid(grid);
  if (!plan && planned && !box.isEmpty()) {
    // Without slack if the cap does not allow it.
    const Box relative = relativeTo(originFor(collider), box);
    grid.lowest = relative.low;
    grid.highest = relative.high;
    plan = planSdfGrid(grid);
  }
  if (!plan)
    return Error{plan.error().code, "collider '" + def.name + "': " + plan.error().message};
  return std::optional<SdfGridPlan>(*plan);
}

SdfBuildDef buildDefOf(const SdfColliderInternals& collider) {
  const bool own = collider.def.vertices == BufferId::kInvalid;
  const LocalOrigin& origin = collider.origin;
  return {.plan = collider.plan,
          .planOrigin = own ? Vector3<double>{} : origin.metres - origin.shifted,
          .triangleCount = collider.topology.triangleCount(),
          .pointCount = collider.topology.pointCount(),
          .vertexCount = collider.vertexCount,
          .vertexStride = own ? 3 : collider.def.vertexStride,
          .vertexOffset = own ? 0 : collider.def.vertexOffset,
          .firstKey = collider.keyOffset,
          .firstSurface = collider.surfaceOffset,
          .motion = true,
          .motionTolerance = collider.def.motionTolerance};
}

Sdf sdfOf(const SdfColliderInternals& collider, const LocalOrigin& origin) {
  if (collider.dense) return sdfOf(*collider.dense, collider.keyOffset, origin);
  Sdf sdf = {};
  const Vector3<double> apart = collider.origin.metres - origin.metres;
  const Vector3<double> first = collider.data ? collider.dataNode : toVector(collider.plan.origin);
  const Float3 node = toFloat3(first + apart);
  if (collider.data) {
    const SdfData& data = *collider.data;
    sdf.origin = {node.x, node.y, node.z, data.grid.cellSize};
    sdf.nodes = {data.grid.nodes[0], data.grid.nodes[1], data.grid.nodes[2], collider.keyOffset};
    sdf.triangleCount = data.triangleCount;
    sdf.triangleBits = data.triangleBits;
    sdf.band = data.band;
    sdf.farRange = data.farRange;
    sdf.surfaceStride = 4;
  } else {
    const SdfGridPlan& plan = collider.plan;
    sdf.origin = {node.x, node.y, node.z, plan.cellSize};
    sdf.nodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2], collider.keyOffset};
    sdf.triangleCount = collider.topology.triangleCount();
    sdf.triangleBits = plan.triangleBits;
    sdf.band = plan.band;
    sdf.farRange = plan.farRange;
    sdf.surfaceStride = 7;
    sdf.motionScale = collider.moves ? 1.0f : 0.0f;
  }
  sdf.surface = collider.surfaceOffset;
  return sdf;
}

float motionSinceBuild(const SdfColliderInternals& collider) {
  if (collider.builtBones.size() != collider.bones.size())
    return std::numeric_limits<float>::infinity();
  if (collider.skeleton != nullptr && collider.skeleton->isOnGpu() &&
      collider.skeleton->version != collider.builtVersion)
    return std::numeric_limits<float>::infinity();
  float largest = 0;
  for (const BoneBox& bone : collider.boneBoxes) {
    largest = std::max(largest, largestDisplacement(bone, collider.builtBones[bone.bone],
                                                    collider.bones[bone.bone]));
  }
  return largest;
}

double wayInCells(const SdfColliderInternals& collider, const BoneMoves& moves, double enough) {
  if (!collider.builtNow || !collider.moves || collider.bonesBefore.size() != collider.bones.size())
    return 0;
  const float cell = collider.plan.cellSize;
  float largest = 0;
  for (const BoneBox& box : collider.boneBoxes) {
    const AffineTransform& before = collider.bonesBefore[box.bone];
    const AffineTransform& now = collider.bones[box.bone];
    const auto way = [&](const AffineTransform& move) {
      return largestDisplacement(box, before, now, move);
    };
    largest = std::max(largest, moves.leastWay(static_cast<float>(enough) * cell, way));
  }
  return double{largest} / double{cell};
}

float movedShare(const SdfColliderInternals& collider, float distance) {
  if (collider.builtBones.size() != collider.bones.size()) return 1;
  uint64_t moved = 0;
  for (const BoneBox& bone : collider.boneBoxes) {
    if (largestDisplacement(bone, collider.builtBones[bone.bone], collider.bones[bone.bone]) >
        distance)
      moved += bone.vertexCount;
  }
  return std::min(
      1.0f, static_cast<float>(moved) / static_cast<float>(std::max(collider.vertexCount, 1u)));
}

}  // namespace detail

SdfCollider::SdfCollider() : internals_(std::make_unique<detail::SdfColliderInternals>()) {}
SdfCollider::~SdfCollider() = default;

const MeshReport& SdfCollider::report() const { return internals_->topology.report; }

uint64_t SdfCollider::memoryBytes() const {
  const detail::SdfColliderInternals& c = *internals_;
  if (c.dense) return detail::nodeCountOf(c.dense->grid) * sizeof(uint32_t);
  return c.data ? c.data->keys.size() * sizeof(uint32_t) : c.plan.bytes;
}

const SdfGrid& SdfCollider::grid() const { return internals_->grid; }

void SdfCollider::setBones(std::span<const AffineTransform> bones) {
  PELAGE_ASSERT(internals_->skeleton == nullptr,
                "the bones are those of a skeleton: SkeletonPose::setBones()");
  PELAGE_ASSERT(bones.size() == internals_->bones.size(),
                "SdfCollider::setBones() takes boneCount transforms");
  // Invalid bones keep all data of the bone, bounds too.
  for (size_t i = 0; i < bones.size(); ++i)
    if (detail::isFinite(bones[i])) internals_->bones[i] = bones[i];
}

void SdfCollider::setVertexBounds(const Float3& low, const Float3& high) {
  internals_->vertexBounds = {low, high};
  internals_->verticesChanged = true;
}

void SdfCollider::setDistances(const DenseSdf& sdf) {
  detail::SdfColliderInternals& c = *internals_;
  PELAGE_ASSERT(c.dense.has_value(), "setDistances() is for a collider with an SDF of the engine");
  if (!c.dense) return;
  c.dense = sdf;
  c.vertexBounds = detail::boxOf(sdf.grid);
  c.grid = sdf.grid;
  ++c.denseVersion;
}

SdfCounters readSdfCounters(std::span<const std::byte> work) {
  using namespace sdf_work;
  PELAGE_ASSERT(work.size() >= (kWorkBricks + 1) * sizeof(uint32_t),
                "readSdfCounters() takes the first 160 bytes of the work buffer");
  uint32_t words[kWorkBricks + 1];
  std::memcpy(words, work.data(), sizeof(words));
  return {.bigTriangles = words[kWorkBigCount],
          .interiorNodes = words[kWorkInteriorCount],
          .movedVertices = words[kWorkMovedPoints],
          .movedTriangles = words[kWorkMovedTriangles],
          .clearedBricks = words[kWorkBricks]};
}

void SdfCollider::reset() { internals_->resetPending = true; }

}  // namespace pelage
