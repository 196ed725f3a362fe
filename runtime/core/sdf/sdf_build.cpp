#include "sdf/sdf_build.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

using namespace sdf_work;

uint64_t groupsOf(uint64_t threads, uint64_t groupSize) {
  return (threads + groupSize - 1) / groupSize;
}

// Groups in x and y of a dispatch in rows.
struct Groups {
  explicit Groups(uint64_t all)
      : x(static_cast<uint32_t>(std::min<uint64_t>(all, dispatch::kRowGroups))),
        y(static_cast<uint32_t>(std::max<uint64_t>(groupsOf(all, dispatch::kRowGroups), 1))) {}
  uint32_t x, y;
};

// Group size of all kernels that an incremental build starts on the GPU, and of a full build.
struct AllGroups {
  explicit AllGroups(const SdfBuildDef& def)
      : points(groupsOf(def.pointCount, kComputePointsGroupSize.x)),
        triangles(groupsOf(def.triangleCount, kScatteredTriangles)),
        surface(groupsOf(def.triangleCount, kSurfaceTriangles)),
        rows(groupsOfRows(def.plan)),
        clear(groupsOf(def.plan.nodeCount() / 4, kClearSdfGroupSize.x)),
        columns(groupsOf(uint64_t{def.plan.nodes[0] / 4} * def.plan.nodes[2], kSummedColumns) +
                groupsOf(uint64_t{def.plan.nodes[0] / 4} * def.plan.nodes[1], kSummedColumns)),
        coarse(groupsOfCoarseNodes(def.plan)) {}
  static uint64_t groupsOfRows(const SdfGridPlan& plan) {
    const uint32_t words = plan.nodes[0] / 4;
    constexpr uint32_t kThreads = kFinalizeSdfGroupSize.x;
    return groupsOf(uint64_t{plan.nodes[1]} * plan.nodes[2], kThreads / std::min(words, kThreads));
  }
  static uint64_t groupsOfCoarseNodes(const SdfGridPlan& plan) {
    const bool wide = plan.band >= sdf_key::kSdfWideBand;
    const uint64_t stride = uint64_t{1}
                            << (wide ? sdf_key::kSdfWideShift : sdf_key::kSdfNarrowShift);
    return groupsOf(plan.nodes[0], stride) * groupsOf(plan.nodes[1], stride) *
           groupsOf(plan.nodes[2], stride);
  }
  Groups points, triangles, surface, rows, clear, columns, coarse;
};

class SdfPasses {
 public:
  SdfPasses(PassList& list, const ResourceTable& resources, const SdfBuildBuffers& buffers,
            const GenerateSdfConstants& block, const SdfBufferSizes& sizes)
      : list_(list),
        resources_(resources),
        buffers_(buffers),
        constants_(block),
        keys_(takeRange(buffers.keys, sizes.keys, sizeof(uint32_t), constants_.sdfNodes.w)),
        surface_(takeRange(buffers.surface, sizes.surface, sizeof(Uint4),
                           constants_.contactSdfSurface)) {}

  void add(const KernelVariant& variant, Groups groups) {
    if (!result.ok()) return;
    PassBuilder builder(list_);
    builder.dispatch(variant, groups.x * variant.groupSize[0], groups.y);
    finish(builder);
  }
  /// \param arguments  word of the work buffer
  void addIndirect(const KernelVariant& variant, uint32_t arguments) {
    if (!result.ok()) return;
    PassBuilder builder(list_);
    builder.dispatchIndirect(variant, buffers_.work, arguments * sizeof(uint32_t));
    finish(builder);
  }
  /// Direct, or indirect with the number of groups that the GPU counted.
  void add(const KernelVariant& variant, Groups groups, uint32_t arguments, bool indirect) {
    if (indirect)
      addIndirect(variant, arguments);
    else
      add(variant, groups);
  }

  Result<void> result;

 private:
  // The part of a buffer that all SDFs share which this build needs, so that it does not wait for
  // those of others. \param first  element of the buffer; then of the range
  BufferRange takeRange(BufferId buffer, uint64_t bytes, uint32_t stride, uint32_t& first) const {
    if (bytes == 0) return resources_.whole(buffer);
    const auto before = static_cast<uint32_t>(first % (kSdfRangeAlignment / stride));
    const uint64_t offset = uint64_t{first - before} * stride;
    first = before;
    return {buffer, uint64_t{before} * stride + bytes, offset};
  }
  void finish(PassBuilder& builder) {
    result = builder.finish(GenerateSDFBindings{
        .generateSdfConstants = constants_,
        .sdfVertices = resources_.whole(buffers_.vertices),
        .sdfPointVertices = resources_.whole(buffers_.pointVertices),
        .sdfIndices = resources_.whole(buffers_.indices),
        .sdfNeighbors = resources_.whole(buffers_.neighbors),
        .sdfFanStarts = resources_.whole(buffers_.fanStarts),
        .sdfFans = resources_.whole(buffers_.fans),
        .sdfPoints = resources_.whole(buffers_.points),
        .sdfKeys = keys_,
        .sdfCounts = resources_.whole(buffers_.counts),
        .sdfSurface = surface_,
        .sdfWork = resources_.whole(buffers_.work),
        .sdfMarks = resources_.whole(buffers_.marks),
        .sdfVotes = resources_.whole(buffers_.votes),
    });
  }

  PassList& list_;
  const ResourceTable& resources_;
  const SdfBuildBuffers& buffers_;
  GenerateSdfConstants constants_;
  BufferRange keys_, surface_;
};

GenerateSdfConstants constantsOf(const SdfBuildDef& def, const AllGroups& groups,
                                 const SdfBuildState& state, bool hasHistory) {
  const SdfGridPlan& plan = def.plan;
  GenerateSdfConstants c = {};
  const auto inVertices = [](float node, double origin) {
    return static_cast<float>(static_cast<double>(node) + origin);
  };
  c.sdfOrigin = {inVertices(plan.origin.x, def.planOrigin.x),
                 inVertices(plan.origin.y, def.planOrigin.y),
                 inVertices(plan.origin.z, def.planOrigin.z), plan.cellSize};
  c.sdfNodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2], def.firstKey};
  c.sdfTriangleCount = def.triangleCount;
  c.sdfTriangleBits = plan.triangleBits;
  c.contactSdfSurface = def.firstSurface;
  c.sdfSurfaceStride = def.motion ? sdf::kSdfMovingRecord : sdf::kSdfStillRecord;
  c.sdfBand = plan.band;
  c.sdfFarRange = plan.farRange;
  c.vertexStride = def.vertexStride;
  c.vertexOffset = def.vertexOffset;
  c.vertexCount = def.vertexCount;
  c.pointCount = def.pointCount;
  c.pointSlot = state.builds % 2;
  c.buildStamp = state.builds + 1;
  const auto shift = [&](float before, float now) {
    return static_cast<float>((static_cast<double>(before) - static_cast<double>(now)) /
                              static_cast<double>(plan.cellSize));
  };
  if (hasHistory)
    c.historyShift = {shift(state.origin.x, plan.origin.x), shift(state.origin.y, plan.origin.y),
                      shift(state.origin.z, plan.origin.z), 1};
  c.triangleGroups = groups.triangles.x;
  c.surfaceGroups = groups.surface.x;
  c.rowGroups = groups.rows.x;
  c.clearGroups = groups.clear.x;
  c.columnGroups = groups.columns.x;
  c.motionTolerance = def.motionTolerance;
  c.coarseGroups = groups.coarse.x;
  return c;
}

// The words that every build starts from.
void uploadWork(PassList& list, BufferId work, const AllGroups& groups, bool motion,
                uint32_t stamp) {
  std::array<uint32_t, kWorkKept + 1> words = {};
  const auto set = [&](uint32_t at, uint32_t y) {
    words[at + 1] = y;
    words[at + 2] = 1;
  };
  set(kWorkBig, 0);
  set(kWorkInterior, groups.coarse.y);
  set(kWorkMoved, groups.triangles.y);
  set(kWorkSurface, groups.surface.y);
  set(kWorkRows, groups.rows.y);
  set(kWorkClear, groups.clear.y);
  set(kWorkColumns, groups.columns.y);
  words[kWorkLastMotion] = stamp;
  // An incremental build keeps the stamp of the last motion.
  const size_t count = motion ? words.size() : kWorkKept;
  addUpload(list, work, std::as_bytes(std::span(words).first(count)));
}

}  // namespace

SdfTables makeSdfTables(const ColliderTopology& topology) {
  SdfTables tables;
  tables.pointVertices = topology.pointVertices;
  tables.neighbors = topology.adjacency;
  tables.indices.reserve(topology.indices.size());
  for (const uint32_t vertex : topology.indices)
    tables.indices.push_back(topology.weldedVertices[vertex]);
  tables.fanStarts = topology.pointOffsets;
  tables.fans.reserve(topology.pointCorners.size());
  for (const uint32_t corner : topology.pointCorners) {
    const uint32_t first = corner / 3 * 3;
    tables.fans.push_back(
        {tables.indices[first + (corner + 1) % 3], tables.indices[first + (corner + 2) % 3]});
  }
  return tables;
}

void flipWinding(SdfTables& tables) {
  for (size_t t = 0; t + 2 < tables.indices.size(); t += 3) {
    std::swap(tables.indices[t + 1], tables.indices[t + 2]);
    // Across the edges 01, 12, 20.
    std::swap(tables.neighbors[t], tables.neighbors[t + 2]);
  }
  for (Uint2& others : tables.fans) std::swap(others.x, others.y);
}

SdfBufferSizes sdfBufferSizes(const SdfBuildDef& def) {
  const uint64_t nodes = def.plan.nodeCount();
  const uint64_t bricks = groupsOf(def.plan.nodes[0], 4) * groupsOf(def.plan.nodes[1], 4) *
                          groupsOf(def.plan.nodes[2], 4);
  SdfBufferSizes sizes;
  sizes.keys = nodes * sizeof(uint32_t);
  sizes.surface = uint64_t{def.triangleCount} *
                  (def.motion ? sdf::kSdfMovingRecord : sdf::kSdfStillRecord) * sizeof(Uint4);
  sizes.counts = nodes * (def.plan.threeAxes ? 3 : 1);
  sizes.points = uint64_t{2} * def.pointCount * sizeof(Float4);
  sizes.work = (kWorkBigList + uint64_t{def.triangleCount}) * sizeof(uint32_t);
  sizes.marks = (bricks + def.pointCount) * sizeof(uint32_t);
  sizes.votes = def.plan.threeAxes ? 2 * nodes : 0;
  return sizes;
}

Result<void> addSdfBuild(PassList& list, const ResourceTable& resources,
                         const SdfBuildBuffers& buffers, const SdfBuildDef& def, SdfBuildMode mode,
                         SdfBuildState& state) {
  const SdfGridPlan& plan = def.plan;
  const bool hasHistory = state.builds > 0 && state.cellSize == plan.cellSize;
  const bool sameGrid = hasHistory && state.origin == plan.origin &&
                        std::equal(std::begin(plan.nodes), std::end(plan.nodes), state.nodes);
  const bool incremental = mode == SdfBuildMode::kIncremental && sameGrid;
  // A mesh of three axes is rebuilt as a whole, but only if something moved: the keys from which
  // finalize_sdf removes triangles depend on triangles that are not near.
  const bool bricks = incremental && !plan.threeAxes;
  const bool three = plan.threeAxes;
  const AllGroups groups(def);
  GenerateSdfConstants constants = constantsOf(def, groups, state, hasHistory);
  constants.buildFlags =
      (incremental ? generate_sdf::kSdfIncremental : 0) | (three ? generate_sdf::kSdfThreeAxes : 0);
  SdfPasses passes(list, resources, buffers, constants, sdfBufferSizes(def));
  ++state.builds;
  state.origin = plan.origin;
  state.cellSize = plan.cellSize;
  std::copy(std::begin(plan.nodes), std::end(plan.nodes), state.nodes);

  uploadWork(list, buffers.work, groups, !incremental, state.builds);
  if (def.pointCount > 0) passes.add(computePointsVariant({}), groups.points);
  if (bricks)
    passes.addIndirect(findMovedTrianglesVariant({}), kWorkMoved);
  else
    passes.add(clearSdfVariant({}), groups.clear, kWorkClear, incremental);
  if (def.triangleCount == 0) return passes.result;

  // The records do not wait for the keys, nor the keys for the records. The records, whose few
  // threads wait for memory most of the time, come first.
  passes.add(updateSurfaceVariant({}), groups.surface, kWorkSurface, incremental);
  passes.add(scatterTrianglesVariant({}), groups.triangles, kWorkMoved, incremental);
  passes.addIndirect(scatterBigTrianglesVariant({}), kWorkBig);
  if (three) passes.add(countSdfColumnsVariant({}), groups.columns, kWorkColumns, incremental);
  passes.add(finalizeSdfVariant({.threeAxes = three}), groups.rows, kWorkRows, incremental);
  passes.add(fillInteriorVariant({}), groups.coarse, kWorkInterior, incremental);
  return passes.result;
}

}  // namespace pelage::detail
