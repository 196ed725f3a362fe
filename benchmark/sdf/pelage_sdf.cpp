// pelage's build of distance fields and its collision, by the functions that a scene uses.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "assets/collider_topology.h"
#include "pelage/gpu_structs.h"
#include "sdf/build_bench.h"
#include "sdf/sdf_build.h"
#include "sdf/sdf_collision.h"
#include "sdf/sdf_grid.h"

namespace bench {

using pelage::BufferDesc;
using pelage::BufferId;
using pelage::BufferUsage;
using pelage::Float3;
using pelage::PassList;
using pelage::Result;
namespace detail = pelage::detail;

namespace {

constexpr double kMovedShare = 0.09;    // of the triangles
constexpr float kMovedDistance = 0.5f;  // cell

Result<detail::ColliderTopology> topologyOf(const SdfShape& shape) {
  const auto& positions = shape.mesh.positions;
  return detail::makeColliderTopology(shape.mesh.indices, static_cast<uint32_t>(positions.size()),
                                      positions);
}

Result<detail::SdfGridPlan> planOf(const SdfShape& shape, uint32_t triangles, float cellSize,
                                   float band, bool threeAxes) {
  detail::SdfGridDef def;
  def.lowest = def.highest = shape.mesh.positions.front();
  for (const Float3& p : shape.mesh.positions) {
    def.lowest = {std::min(def.lowest.x, p.x), std::min(def.lowest.y, p.y),
                  std::min(def.lowest.z, p.z)};
    def.highest = {std::max(def.highest.x, p.x), std::max(def.highest.y, p.y),
                   std::max(def.highest.z, p.z)};
  }
  def.cellSize = cellSize;
  def.band = band;
  def.triangleCount = triangles;
  def.threeAxes = threeAxes;
  return detail::planSdfGrid(def);
}

std::vector<float> flatten(const std::vector<Float3>& positions) {
  std::vector<float> values;
  for (const Float3& p : positions) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

// The vertices of the highest triangles, as a jaw or a brow is a part of a face.
std::vector<bool> movedVertices(const SdfShape& shape) {
  const auto& mesh = shape.mesh;
  std::vector<std::pair<float, uint32_t>> heights;
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t)
    heights.emplace_back(-mesh.positions[mesh.indices[size_t{t} * 3]].y, t);
  std::sort(heights.begin(), heights.end());
  // Triangles around the moved ones move, too: about a twentieth more.
  heights.resize(static_cast<size_t>(0.95 * kMovedShare * static_cast<double>(heights.size())));
  std::vector<bool> moved(mesh.positions.size());
  for (const auto& [height, t] : heights)
    for (size_t k = 0; k < 3; ++k) moved[mesh.indices[size_t{t} * 3 + k]] = true;
  return moved;
}

class PelageSdf : public SdfBuild {
 public:
  PelageSdf(Workbench& workbench, const SdfShape& shape, const detail::ColliderTopology& topology,
            const detail::SdfGridPlan& plan, SdfMotion motion)
      : workbench_(workbench), vertices_(flatten(shape.mesh.positions)), motion_(motion) {
    def_.plan = plan;
    def_.triangleCount = topology.triangleCount();
    def_.pointCount = topology.pointCount();
    def_.vertexCount = static_cast<uint32_t>(shape.mesh.positions.size());
    def_.motionTolerance = motion == SdfMotion::kAll ? 0 : 0.01f;
    if (motion == SdfMotion::kPart) moved_ = movedVertices(shape);
    addBuffers(topology);
  }
  ~PelageSdf() override {
    for (const BufferId buffer : owned_) workbench_.scene.resources().remove(buffer);
  }

  Result<void> addBuild(PassList& list) override {
    if (motion_ == SdfMotion::kPart) moveVertices(list);
    const auto mode = motion_ == SdfMotion::kAll ? detail::SdfBuildMode::kFull
                                                 : detail::SdfBuildMode::kIncremental;
    return addSdfBuild(list, workbench_.scene.resources(), buffers_, def_, mode, state_);
  }

  std::vector<Response> responses() const override {
    return {Response::kTrilinear, Response::kClosestFeature};
  }

  Result<void> addCollision(PassList& list, const CollidingVertices& hair,
                            Response response) override {
    return detail::addSdfCollision(
        list, workbench_.scene.resources(),
        {hair.positions, hair.before, fields_, buffers_.keys, buffers_.surface},
        {.vertexCount = hair.count,
         .contactSdfCount = 1,
         .closestFeature = response != Response::kTrilinear});
  }

  // kernels/sdf/sdf_key.hlsli says what a key holds.
  Result<std::vector<NodeValue>> nodes() override {
    const auto raw = workbench_.device.read(buffers_.keys);
    if (!raw) return raw.error();
    const detail::SdfGridPlan& plan = def_.plan;
    const auto most = static_cast<float>((1u << (30 - plan.triangleBits)) - 1);
    std::vector<NodeValue> values(plan.nodeCount());
    for (size_t i = 0; i < values.size(); ++i) {
      uint32_t key = 0;
      std::memcpy(&key, raw->data() + i * sizeof key, sizeof key);
      const uint32_t magnitude = key & 0x7fffffffu;
      const bool far = (magnitude & 0x40000000u) != 0;
      const auto code = static_cast<float>((magnitude & 0x3fffffffu) >> plan.triangleBits);
      NodeValue& value = values[i];
      value = {NodeState::kUnfilled, plan.band};
      if (magnitude != 0x7fffffffu && far)
        value = {NodeState::kFar, plan.band + code / most * plan.farRange};
      else if (magnitude != 0x7fffffffu)
        value = {NodeState::kNear, code / most * plan.band};
      if ((key & 0x80000000u) != 0) value.distance = -value.distance;
    }
    return values;
  }

  uint64_t nodeCount() const override { return def_.plan.nodeCount(); }
  uint64_t sdfBytes() const override {
    const detail::SdfBufferSizes sizes = detail::sdfBufferSizes(def_);
    return sizes.keys + sizes.counts;
  }
  uint64_t bytes() const override { return bytes_; }

 private:
  template <class T>
  BufferId addValues(const char* name, const std::vector<T>& values) {
    owned_.push_back(workbench_.add(name, values));
    return owned_.back();
  }
  BufferId addBuffer(const char* name, uint64_t size) {
    if (size == 0) return BufferId::kInvalid;
    BufferDesc desc;
    desc.name = name;
    desc.size = size;
    desc.stride = 4;
    desc.usage = BufferUsage::kStorage | BufferUsage::kUpload | BufferUsage::kReadback |
                 BufferUsage::kIndirect;
    bytes_ += size;
    owned_.push_back(workbench_.scene.resources().add(std::move(desc)));
    return owned_.back();
  }

  void addBuffers(const detail::ColliderTopology& topology) {
    const detail::SdfTables tables = detail::makeSdfTables(topology);
    buffers_.pointVertices = addValues("pointVertices", tables.pointVertices);
    buffers_.indices = addValues("indices", tables.indices);
    buffers_.neighbors = addValues("neighbors", tables.neighbors);
    buffers_.fanStarts = addValues("fanStarts", tables.fanStarts);
    buffers_.fans = addValues("fans", tables.fans);
    BufferDesc desc;
    desc.name = "vertices";
    desc.size = vertices_.size() * sizeof(float);
    desc.stride = sizeof(float);
    desc.usage = BufferUsage::kStorage | BufferUsage::kUpload;
    const auto initial = std::as_bytes(std::span(vertices_));
    desc.initial.assign(initial.begin(), initial.end());
    owned_.push_back(workbench_.scene.resources().add(std::move(desc)));
    buffers_.vertices = owned_.back();

    const detail::SdfBufferSizes sizes = detail::sdfBufferSizes(def_);
    buffers_.keys = addBuffer("keys", sizes.keys);
    buffers_.surface = addBuffer("surface", sizes.surface);
    buffers_.counts = addBuffer("counts", sizes.counts);
    buffers_.points = addBuffer("points", sizes.points);
    buffers_.work = addBuffer("work", sizes.work);
    buffers_.marks = addBuffer("marks", sizes.marks);
    buffers_.votes = addBuffer("votes", sizes.votes);

    const detail::SdfGridPlan& plan = def_.plan;
    pelage::Sdf sdf = {};
    sdf.origin = {plan.origin.x, plan.origin.y, plan.origin.z, plan.cellSize};
    sdf.nodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2], 0};
    sdf.triangleCount = def_.triangleCount;
    sdf.triangleBits = plan.triangleBits;
    sdf.surfaceStride = 4;
    sdf.band = plan.band;
    sdf.farRange = plan.farRange;
    sdf.friction = 0.3f;
    fields_ = addValues("fields", std::vector<pelage::Sdf>{sdf});
  }

  // There and back: after an even number of builds the mesh is as it was.
  void moveVertices(PassList& list) {
    const bool away = state_.builds % 2 == 0;
    std::vector<float> now = vertices_;
    for (size_t v = 0; away && v < moved_.size(); ++v)
      if (moved_[v]) now[v * 3 + 2] += kMovedDistance * def_.plan.cellSize;
    pelage::addUpload(list, buffers_.vertices, std::as_bytes(std::span(now)));
  }

  Workbench& workbench_;
  std::vector<float> vertices_;
  SdfMotion motion_;
  std::vector<bool> moved_;  // [vertex]
  detail::SdfBuildDef def_;
  detail::SdfBuildBuffers buffers_;
  detail::SdfBuildState state_;
  BufferId fields_ = BufferId::kInvalid;
  std::vector<BufferId> owned_;
  uint64_t bytes_ = 0;
};

}  // namespace

Result<NodeGrid> comparedGrid(const SdfShape& shape, float cellSize, float band) {
  const auto plan = planOf(shape, shape.mesh.triangleCount(), cellSize, band, false);
  if (!plan) return plan.error();
  return NodeGrid{plan->origin, plan->cellSize, {plan->nodes[0], plan->nodes[1], plan->nodes[2]}};
}

Result<std::unique_ptr<SdfBuild>> makePelageSdf(Workbench& workbench, const SdfShape& shape,
                                                const NodeGrid& compared, const SdfMethod& method) {
  const auto topology = topologyOf(shape);
  if (!topology) return topology.error();
  auto plan =
      planOf(shape, topology->triangleCount(), compared.cellSize, method.band, method.threeAxes);
  if (!plan) return plan.error();
  if (method.keyBits > 0) plan->triangleBits = std::max(plan->triangleBits, 30 - method.keyBits);
  return std::unique_ptr<SdfBuild>(
      new PelageSdf(workbench, shape, *topology, *plan, method.motion));
}

}  // namespace bench
