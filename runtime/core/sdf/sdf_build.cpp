#include "sdf/sdf_build.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

// As in kernels/sdf/sdf_work.hlsli.
constexpr uint32_t kGroupsARow = 32768;
constexpr uint32_t kWorkKept = 40;
constexpr uint32_t kWorkBigList = 44;
// As in kernels/layouts/generate_sdf.hlsli.
constexpr uint32_t kIncremental = 1, kThreeAxes = 2;
enum class Work : uint32_t {
  kBig = 0,
  kInterior = 4,
  kMoved = 8,
  kSurface = 12,
  kRows = 16,
  kClear = 20,
  kColumns = 24,
  kLastMotion = 40,
};

uint64_t groupsOf(uint64_t threads, uint64_t groupSize) {
  return (threads + groupSize - 1) / groupSize;
}

// Groups in x and y of a dispatch in rows.
struct Groups {
  explicit Groups(uint64_t all)
      : x(static_cast<uint32_t>(std::min<uint64_t>(all, kGroupsARow))),
        y(static_cast<uint32_t>(std::max<uint64_t>(groupsOf(all, kGroupsARow), 1))) {}
  uint32_t x, y;
};

// Of all kernels that an incremental build starts on the GPU, and of a full one.
struct AllGroups {
  explicit AllGroups(const SdfBuildDef& def)
      : places(groupsOf(def.placeCount, 64)),
        triangles(groupsOf(def.triangleCount, 4)),
        surface(groupsOf(def.triangleCount, 16)),
        rows(groupsOfRows(def.plan)),
        clear(groupsOf(def.plan.nodeCount() / 4, 128)),
        columns(groupsOf(uint64_t{def.plan.nodes[0] / 4} * def.plan.nodes[2], 16) +
                groupsOf(uint64_t{def.plan.nodes[0] / 4} * def.plan.nodes[1], 16)),
        coarse(groupsOfCoarseNodes(def.plan)) {}
  static uint64_t groupsOfRows(const SdfGridPlan& plan) {
    const uint32_t words = plan.nodes[0] / 4;
    return groupsOf(uint64_t{plan.nodes[1]} * plan.nodes[2], 64 / std::min(words, 64u));
  }
  // As sdfCoarseStride() in kernels/sdf/sdf_key.hlsli.
  static uint64_t groupsOfCoarseNodes(const SdfGridPlan& plan) {
    const uint64_t stride = plan.band >= 2 ? 4 : 2;
    return groupsOf(plan.nodes[0], stride) * groupsOf(plan.nodes[1], stride) *
           groupsOf(plan.nodes[2], stride);
  }
  Groups places, triangles, surface, rows, clear, columns, coarse;
};

class SdfPasses {
 public:
  SdfPasses(PassList& list, const ResourceTable& resources, const SdfBuildBuffers& buffers,
            const GenerateSdfConstants& block)
      : list_(list), resources_(resources), buffers_(buffers), constants_(block) {}

  void add(const KernelVariant& variant, Groups groups) {
    if (!result.ok()) return;
    PassBuilder builder(list_);
    builder.dispatch(variant, groups.x * variant.groupSize[0], groups.y);
    finish(builder);
  }
  void addIndirect(const KernelVariant& variant, Work arguments) {
    if (!result.ok()) return;
    PassBuilder builder(list_);
    builder.dispatchIndirect(variant, buffers_.work,
                             static_cast<uint64_t>(arguments) * sizeof(uint32_t));
    finish(builder);
  }
  /// Direct, or with as many groups as the GPU finds that there are.
  void add(const KernelVariant& variant, Groups groups, Work arguments, bool indirect) {
    if (indirect)
      addIndirect(variant, arguments);
    else
      add(variant, groups);
  }

  Result<void> result;

 private:
  void finish(PassBuilder& builder) {
    const std::pair<const char*, BufferId> all[] = {
        {"g_sdfVertices", buffers_.vertices},   {"g_sdfPlaceVertices", buffers_.placeVertices},
        {"g_sdfIndices", buffers_.indices},     {"g_sdfNeighbors", buffers_.neighbors},
        {"g_sdfFanStarts", buffers_.fanStarts}, {"g_sdfFans", buffers_.fans},
        {"g_sdfPlaces", buffers_.places},       {"g_sdfKeys", buffers_.keys},
        {"g_sdfCounts", buffers_.counts},       {"g_sdfSurface", buffers_.surface},
        {"g_sdfWork", buffers_.work},           {"g_sdfMarks", buffers_.marks},
        {"g_sdfVotes", buffers_.votes}};
    for (const auto& [name, buffer] : all)
      if (const BufferDesc* desc = resources_.find(buffer)) builder.bind(name, buffer, desc->size);
    builder.constants("GenerateSdfConstants", constants_);
    result = builder.finish();
  }

  PassList& list_;
  const ResourceTable& resources_;
  const SdfBuildBuffers& buffers_;
  GenerateSdfConstants constants_;
};

GenerateSdfConstants constantsOf(const SdfBuildDef& def, const AllGroups& groups,
                                 const SdfBuildState& state, bool hasHistory) {
  const SdfGridPlan& plan = def.plan;
  GenerateSdfConstants c = {};
  const auto inVertices = [](float node, double origin) {
    return static_cast<float>(static_cast<double>(node) + origin);
  };
  c.fieldOrigin = {inVertices(plan.origin.x, def.planOrigin.x),
                   inVertices(plan.origin.y, def.planOrigin.y),
                   inVertices(plan.origin.z, def.planOrigin.z), plan.cellSize};
  c.fieldNodes = {plan.nodes[0], plan.nodes[1], plan.nodes[2], def.firstKey};
  c.fieldTriangleCount = def.triangleCount;
  c.fieldTriangleBits = plan.triangleBits;
  c.fieldSurface = def.firstSurface;
  c.fieldSurfaceStride = def.motion ? 7 : 4;
  c.fieldBand = plan.band;
  c.fieldFarRange = plan.farRange;
  c.vertexStride = def.vertexStride;
  c.vertexOffset = def.vertexOffset;
  c.vertexCount = def.vertexCount;
  c.placeCount = def.placeCount;
  c.placeSlot = state.builds % 2;
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
  const auto set = [&](Work at, uint32_t y) {
    words[static_cast<uint32_t>(at) + 1] = y;
    words[static_cast<uint32_t>(at) + 2] = 1;
  };
  set(Work::kBig, 0);
  set(Work::kInterior, groups.coarse.y);
  set(Work::kMoved, groups.triangles.y);
  set(Work::kSurface, groups.surface.y);
  set(Work::kRows, groups.rows.y);
  set(Work::kClear, groups.clear.y);
  set(Work::kColumns, groups.columns.y);
  words[static_cast<uint32_t>(Work::kLastMotion)] = stamp;
  // An incremental build keeps the stamp of the last motion.
  const size_t count = motion ? words.size() : kWorkKept;
  addUpload(list, work, std::as_bytes(std::span(words).first(count)));
}

}  // namespace

SdfTables makeSdfTables(const ColliderTopology& topology) {
  SdfTables tables;
  tables.placeVertices = topology.placeVertices;
  tables.neighbors = topology.adjacency;
  tables.indices.reserve(topology.indices.size());
  for (const uint32_t vertex : topology.indices)
    tables.indices.push_back(topology.weldedVertices[vertex]);
  tables.fanStarts = topology.placeOffsets;
  tables.fans.reserve(topology.placeCorners.size());
  for (const uint32_t corner : topology.placeCorners) {
    const uint32_t first = corner / 3 * 3;
    tables.fans.push_back(
        {tables.indices[first + (corner + 1) % 3], tables.indices[first + (corner + 2) % 3]});
  }
  return tables;
}

void turnRound(SdfTables& tables) {
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
  sizes.surface = uint64_t{def.triangleCount} * (def.motion ? 7 : 4) * sizeof(Uint4);
  sizes.counts = nodes * (def.plan.threeAxes ? 3 : 1);
  sizes.places = uint64_t{2} * def.placeCount * sizeof(Float4);
  sizes.work = (kWorkBigList + uint64_t{def.triangleCount}) * sizeof(uint32_t);
  sizes.marks = (bricks + def.placeCount) * sizeof(uint32_t);
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
  // A mesh of three axes is rebuilt as a whole, but only when something moved: the keys that
  // finalize_sdf takes the triangles from depend on other triangles than those that are near.
  const bool bricks = incremental && !plan.threeAxes;
  const bool three = plan.threeAxes;
  const AllGroups groups(def);
  GenerateSdfConstants constants = constantsOf(def, groups, state, hasHistory);
  constants.buildFlags = (incremental ? kIncremental : 0) | (three ? kThreeAxes : 0);
  SdfPasses passes(list, resources, buffers, constants);
  ++state.builds;
  state.origin = plan.origin;
  state.cellSize = plan.cellSize;
  std::copy(std::begin(plan.nodes), std::end(plan.nodes), state.nodes);

  uploadWork(list, buffers.work, groups, !incremental, state.builds);
  if (def.placeCount > 0) passes.add(placeVerticesVariant({}), groups.places);
  if (bricks)
    passes.addIndirect(findMovedTrianglesVariant({}), Work::kMoved);
  else
    passes.add(clearSdfVariant({}), groups.clear, Work::kClear, incremental);
  if (def.triangleCount == 0) return passes.result;

  // The records do not wait for the keys, nor the keys for the records. The records, whose few
  // threads wait for memory most of the time, come first.
  passes.add(updateSurfaceVariant({}), groups.surface, Work::kSurface, incremental);
  passes.add(scatterTrianglesVariant({}), groups.triangles, Work::kMoved, incremental);
  passes.addIndirect(scatterBigTrianglesVariant({}), Work::kBig);
  if (three) passes.add(countSdfColumnsVariant({}), groups.columns, Work::kColumns, incremental);
  passes.add(finalizeSdfVariant({.threeAxes = three}), groups.rows, Work::kRows, incremental);
  passes.add(fillInteriorVariant({}), groups.coarse, Work::kInterior, incremental);
  return passes.result;
}

}  // namespace pelage::detail
