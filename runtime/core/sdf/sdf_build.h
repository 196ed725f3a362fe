// The passes that build a signed distance field: kernels/sdf.
#pragma once

#include <cstdint>
#include <vector>

#include "assets/collider_topology.h"
#include "base/vector3.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "sdf/sdf_grid.h"

namespace pelage::detail {

/// Contents of the static buffers.
struct SdfTables {
  std::vector<uint32_t> placeVertices;  ///< g_sdfPlaceVertices
  std::vector<uint32_t> indices;        ///< g_sdfIndices
  std::vector<uint32_t> neighbors;      ///< g_sdfNeighbors
  std::vector<uint32_t> fanStarts;      ///< g_sdfFanStarts
  std::vector<Uint2> fans;              ///< g_sdfFans
};
SdfTables makeSdfTables(const ColliderTopology& topology);
/// Turns every triangle round: the second and the third corner change places.
void turnRound(SdfTables& tables);

/// What is built, and from what.
struct SdfBuildDef {
  SdfGridPlan plan;
  Vector3<double> planOrigin;  ///< what the plan is relative to, in the space of the vertices [m]
  uint32_t triangleCount = 0, placeCount = 0;
  uint32_t vertexCount = 0;   ///< of the vertex buffer
  uint32_t vertexStride = 3;  ///< [float]
  uint32_t vertexOffset = 0;  ///< of x [float]
  uint32_t firstKey = 0;      ///< SdfField::nodes.w
  uint32_t firstSurface = 0;  ///< SdfField::surface
  bool motion = false;        ///< records have 7 elements
  float motionTolerance = 0;  ///< [cell], see g_motionTolerance
};

/// Bytes of the buffers that a field needs of its own; keys and surface may be shared.
struct SdfBufferSizes {
  uint64_t keys = 0, surface = 0;
  uint64_t counts = 0;  ///< persistent when the field is built incrementally
  uint64_t places = 0, work = 0, marks = 0;
  uint64_t votes = 0;  ///< scratch of a build of three axes
};
SdfBufferSizes sdfBufferSizes(const SdfBuildDef& def);

/// Empty ones (kInvalid) where the def needs none.
struct SdfBuildBuffers {
  BufferId vertices = BufferId::kInvalid;
  BufferId placeVertices = BufferId::kInvalid, indices = BufferId::kInvalid;
  BufferId neighbors = BufferId::kInvalid, fanStarts = BufferId::kInvalid;
  BufferId fans = BufferId::kInvalid;
  BufferId keys = BufferId::kInvalid, surface = BufferId::kInvalid;
  BufferId counts = BufferId::kInvalid, places = BufferId::kInvalid;
  BufferId work = BufferId::kInvalid;  ///< BufferUsage: storage, indirect and upload
  BufferId marks = BufferId::kInvalid, votes = BufferId::kInvalid;
};

/// What a build has to know of the one before it.
struct SdfBuildState {
  uint32_t builds = 0;     ///< so far
  Float3 origin = {};      ///< of the last one's grid
  float cellSize = 0;      ///< of the last one
  uint32_t nodes[3] = {};  ///< of the last one
};

enum class SdfBuildMode : uint8_t {
  kFull,         ///< from the vertices alone
  kIncremental,  ///< what moved since it was built; needs the last build's grid, with the counts,
                 ///< places, marks and work that it left; else it is a full one
};

/// Words of the work buffer that say what a build did.
struct SdfBuildCounters {
  static constexpr uint64_t kOffset = 32 * sizeof(uint32_t);  ///< bytes into the work buffer
  uint32_t bigTriangles = 0;                                  ///< that were shared by groups
  uint32_t interiorNodes = 0;   ///< coarse nodes that fill_interior gave a triangle
  uint32_t movedPlaces = 0;     ///< incremental builds: vertices that moved
  uint32_t movedTriangles = 0;  ///< incremental builds, but of three axes
  uint32_t clearedBricks = 0;   ///< likewise
};

/// Adds the passes of one build. In an incremental one all but the first are started on the GPU,
/// and have no groups when nothing moved. Errors: those of PassBuilder::finish().
Result<void> addSdfBuild(PassList& list, const ResourceTable& resources,
                         const SdfBuildBuffers& buffers, const SdfBuildDef& def, SdfBuildMode mode,
                         SdfBuildState& state);

}  // namespace pelage::detail
