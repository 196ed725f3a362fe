// A signed distance field that the kernels build, and what tests ask of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "reference/sdf/distance_oracle.h"
#include "reference/sdf/mesh_shapes.h"
#include "sdf/sdf_build.h"
#include "support/strand_measures.h"

namespace pelage::test {

using Eigen::Vector3d;
using reference::DistanceOracle;
using reference::TriangleMesh;

struct SdfOptions {
  float cellSize = 0.1f;
  float band = 2;
  bool threeAxes = false;
  bool motion = false;
  float motionTolerance = 0;
  uint32_t firstKey = 0;
  /// The box of the grid, where it is not that of the mesh.
  std::vector<Float3> box = {};
};

inline bool isFinite(const Float3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// A grid around the finite vertices, or around the box of the options.
inline Result<detail::SdfGridPlan> planOf(const TriangleMesh& mesh, const SdfOptions& options) {
  detail::SdfGridDef def;
  const float most = std::numeric_limits<float>::max();
  def.lowest = {most, most, most};
  def.highest = {-most, -most, -most};
  for (const Float3& p : options.box.empty() ? mesh.positions : options.box) {
    if (!isFinite(p)) continue;
    def.lowest = {std::min(def.lowest.x, p.x), std::min(def.lowest.y, p.y),
                  std::min(def.lowest.z, p.z)};
    def.highest = {std::max(def.highest.x, p.x), std::max(def.highest.y, p.y),
                   std::max(def.highest.z, p.z)};
  }
  def.cellSize = options.cellSize;
  def.band = options.band;
  def.threeAxes = options.threeAxes;
  def.triangleCount = mesh.triangleCount();
  return detail::planSdfGrid(def);
}

class SdfRun {
 public:
  static constexpr uint32_t kVertexStride = 5, kVertexOffset = 1;  // [float]

  SdfRun(Gpu& gpu, const TriangleMesh& mesh, const SdfOptions& options)
      : gpu_(gpu), vertexCount_(static_cast<uint32_t>(mesh.positions.size())) {
    auto topology = detail::makeColliderTopology(mesh.indices, vertexCount_, mesh.positions);
    EXPECT_TRUE(topology.ok()) << (topology.ok() ? "" : topology.error().message);
    const detail::SdfTables tables = detail::makeSdfTables(*topology);
    auto plan = planOf(mesh, options);
    EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message);
    def.plan = *plan;
    def.triangleCount = topology->triangleCount();
    def.pointCount = topology->pointCount();
    def.vertexCount = vertexCount_;
    def.vertexStride = kVertexStride;
    def.vertexOffset = kVertexOffset;
    def.firstKey = options.firstKey;
    def.motion = options.motion;
    def.motionTolerance = options.motionTolerance;
    const detail::SdfBufferSizes sizes = detail::sdfBufferSizes(def);

    add(vertices, "vertices", interleaved(mesh.positions));
    add(pointVertices, "pointVertices", tables.pointVertices);
    add(indices, "indices", tables.indices);
    add(neighbors, "neighbors", tables.neighbors);
    add(fanStarts, "fanStarts", tables.fanStarts);
    add(fans, "fans", tables.fans);
    // Patterns show words that nobody writes.
    add(keys, "keys", std::vector<uint32_t>(options.firstKey + sizes.keys / 4, 0x12345678u));
    add(surface, "surface", std::vector<Uint4>(sizes.surface / 16, {7, 7, 7, 7}));
    add(counts, "counts", std::vector<uint32_t>(sizes.counts / 4, 0x7f7f7f7fu));
    add(points, "points", std::vector<Float4>(sizes.points / 16, {1e5f, 2e5f, 3e5f, 4e5f}));
    add(marks, "marks", std::vector<uint32_t>(sizes.marks / 4));
    add(votes, "votes", std::vector<uint32_t>(std::max<uint64_t>(sizes.votes / 4, 1), 0x03030303u));
    work_ = gpu.resources.add({.name = "work",
                               .size = sizes.work,
                               .stride = 4,
                               .usage = BufferUsage::kStorage | BufferUsage::kIndirect |
                                        BufferUsage::kUpload | BufferUsage::kReadback});
    expectOk(gpu.device()->update(gpu.resources));
  }
  ~SdfRun() {
    gpu_.hazards.forget(work_);
    gpu_.resources.remove(work_);
  }

  void build(detail::SdfBuildMode mode = detail::SdfBuildMode::kFull,
             std::vector<PassTiming>* timings = nullptr) {
    PassList list;
    if (!moved_.empty()) vertices->upload(list, interleaved(moved_));
    moved_.clear();
    expectOk(detail::addSdfBuild(list, gpu_.resources, buffers(), def, mode, state));
    gpu_.hazards.resolve(list);
    expectOk(gpu_.device()->execute(list, timings));
    allKeys_.clear();
  }
  /// The vertices of the next build.
  void move(const std::vector<Float3>& positions) { moved_ = positions; }

  detail::SdfBuildBuffers buffers() const {
    return {vertices->id(), pointVertices->id(), indices->id(), neighbors->id(), fanStarts->id(),
            fans->id(),     keys->id(),          surface->id(), counts->id(),    points->id(),
            work_,          marks->id(),         votes->id()};
  }
  std::vector<uint32_t> words() const {
    const auto raw = gpu_.device()->read(work_);
    EXPECT_TRUE(raw.ok());
    std::vector<uint32_t> result(raw->size() / 4);
    std::memcpy(result.data(), raw->data(), result.size() * 4);
    return result;
  }
  detail::SdfBuildCounters counters() const {
    const std::vector<uint32_t> all = words();
    const uint32_t* at = &all[detail::SdfBuildCounters::kOffset / 4];
    detail::SdfBuildCounters result = {at[0], at[1], at[2], at[3], at[4]};
    return result;
  }

  const std::vector<uint32_t>& allKeys() {
    if (allKeys_.empty()) allKeys_ = keys->read();
    return allKeys_;
  }
  /// As collisions take it.
  Sdf sdf() const {
    Sdf sdf = {};
    sdf.origin = {def.plan.origin.x, def.plan.origin.y, def.plan.origin.z, def.plan.cellSize};
    sdf.nodes = {def.plan.nodes[0], def.plan.nodes[1], def.plan.nodes[2], 0};
    sdf.triangleCount = def.triangleCount;
    sdf.triangleBits = def.plan.triangleBits;
    sdf.surfaceStride = def.motion ? 7 : 4;
    sdf.band = def.plan.band;
    sdf.farRange = def.plan.farRange;
    return sdf;
  }
  uint64_t nodeCount() const { return def.plan.nodeCount(); }
  uint32_t key(uint64_t node) { return allKeys()[def.firstKey + node]; }
  bool isInside(uint64_t node) { return (key(node) >> 31) != 0; }
  bool isSet(uint64_t node) { return (key(node) & 0x7fffffffu) != 0x7fffffffu; }
  bool isFar(uint64_t node) { return isSet(node) && (key(node) & 0x40000000u) != 0; }
  /// Whether a node of the coarse grid: these have triangles however deep they are.
  bool isCoarse(uint64_t node) const {
    const uint64_t stride = def.plan.band >= 2 ? 4 : 2, row = node / def.plan.nodes[0];
    return node % def.plan.nodes[0] % stride == 0 && row % def.plan.nodes[1] % stride == 0 &&
           row / def.plan.nodes[1] % stride == 0;
  }
  uint32_t triangle(uint64_t node) { return key(node) & ((1u << def.plan.triangleBits) - 1); }
  /// [cell], without its sign.
  double distance(uint64_t node) {
    const double most = std::exp2(30 - static_cast<int>(def.plan.triangleBits)) - 1;
    const double code = (key(node) & 0x3fffffffu) >> def.plan.triangleBits;
    const double band = static_cast<double>(def.plan.band);
    if (!isSet(node)) return band;
    return isFar(node) ? band + code / most * static_cast<double>(def.plan.farRange)
                       : code / most * band;
  }

  detail::SdfBuildDef def;
  detail::SdfBuildState state;
  std::unique_ptr<GuardedBuffer<float>> vertices;
  std::unique_ptr<GuardedBuffer<uint32_t>> pointVertices, indices, neighbors, fanStarts;
  std::unique_ptr<GuardedBuffer<Uint2>> fans;
  std::unique_ptr<GuardedBuffer<uint32_t>> keys, counts, marks, votes;
  std::unique_ptr<GuardedBuffer<Uint4>> surface;
  std::unique_ptr<GuardedBuffer<Float4>> points;

 private:
  template <class T>
  void add(std::unique_ptr<GuardedBuffer<T>>& buffer, const char* name,
           const std::vector<T>& data) {
    buffer = std::make_unique<GuardedBuffer<T>>(gpu_, name, data);
  }
  static std::vector<float> interleaved(const std::vector<Float3>& positions) {
    std::vector<float> all(kVertexOffset + positions.size() * kVertexStride, 1e6f);
    for (size_t i = 0; i < positions.size(); ++i)
      std::memcpy(&all[kVertexOffset + i * kVertexStride], &positions[i], sizeof(Float3));
    return all;
  }

  Gpu& gpu_;
  uint32_t vertexCount_;
  std::vector<Float3> moved_;
  std::vector<uint32_t> allKeys_;
  BufferId work_ = BufferId::kInvalid;
};

/// Distances at the nodes [cell], negative inside.
inline std::vector<double> trueDistances(const SdfRun& run, const TriangleMesh& mesh,
                                         double range = 1e300) {
  const detail::SdfGridPlan& plan = run.def.plan;
  const Vector3d origin = {static_cast<double>(plan.origin.x), static_cast<double>(plan.origin.y),
                           static_cast<double>(plan.origin.z)};
  const double cell = static_cast<double>(plan.cellSize);
  std::vector<double> distances =
      DistanceOracle(mesh).gridDistances(origin, cell, plan.nodes, range * cell);
  for (double& d : distances) d /= cell;
  return distances;
}

/// Errors of a field.
struct SdfErrors {
  uint64_t wrongSigns = 0;    ///< at |d| >= 1e-4 cell
  uint64_t unsetInside = 0;   ///< coarse nodes
  uint64_t missing = 0;       ///< nodes within the band without a near key
  uint64_t misplacedFar = 0;  ///< nodes with a far key that are outside or not coarse
  double band = 0;            ///< greatest error of a distance within the band [cell]
  double interior = 0;        ///< and beyond it, of coarse nodes
  double interiorMean = 0;
  uint64_t far = 0;  ///< coarse nodes beyond the band, inside
};

inline SdfErrors errorsOf(SdfRun& run, const std::vector<double>& truth) {
  SdfErrors errors;
  const double band = static_cast<double>(run.def.plan.band);
  for (uint64_t i = 0; i < run.nodeCount(); ++i) {
    const double d = truth[i];
    const bool inside = run.isInside(i);
    if (std::abs(d) >= 1e-4 && inside != (d < 0)) ++errors.wrongSigns;
    if (std::abs(d) < band - 1e-3 && (!run.isSet(i) || run.isFar(i))) ++errors.missing;
    if (inside && !run.isSet(i) && run.isCoarse(i)) ++errors.unsetInside;
    if (run.isFar(i) && (!inside || !run.isCoarse(i))) ++errors.misplacedFar;
    if (!run.isSet(i)) continue;
    const double error = std::abs(run.distance(i) - std::abs(d));
    if (run.isFar(i)) {
      ++errors.far;
      keepLargest(errors.interior, error);
      errors.interiorMean += error;
    } else {
      keepLargest(errors.band, error);
    }
  }
  if (errors.far > 0) errors.interiorMean /= static_cast<double>(errors.far);
  return errors;
}

}  // namespace pelage::test
