// The passes that build an SDF: kernels/sdf.
#pragma once

#include <cstdint>
#include <vector>

#include "assets/collider_topology.h"
#include "base/vector3.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "sdf/sdf_grid.h"

namespace pelage::detail {

/// Contents of the static buffers.
struct SdfTables {
  std::vector<uint32_t> pointVertices;  ///< g_sdfPointVertices
  std::vector<uint32_t> indices;        ///< g_sdfIndices
  std::vector<uint32_t> neighbors;      ///< g_sdfNeighbors
  std::vector<uint32_t> fanStarts;      ///< g_sdfFanStarts
  std::vector<Uint2> fans;              ///< g_sdfFans
};
SdfTables makeSdfTables(const ColliderTopology& topology);
/// Flips every triangle: swaps the second and the third corner.
void flipWinding(SdfTables& tables);

/// The definition of a build.
struct SdfBuildDef {
  SdfGridPlan plan;
  Vector3<double> planOrigin;  ///< what the plan is relative to, in the space of the vertices [m]
  uint32_t triangleCount = 0, pointCount = 0;
  uint32_t vertexCount = 0;   ///< of the vertex buffer
  uint32_t vertexStride = 3;  ///< [float]
  uint32_t vertexOffset = 0;  ///< of x [float]
  uint32_t firstKey = 0;      ///< Sdf::nodes.w
  uint32_t firstSurface = 0;  ///< Sdf::surface
  bool motion = false;        ///< records have 7 elements
  float motionTolerance = 0;  ///< [cell], see g_motionTolerance
};

/// Offsets of ranges of storage buffers may be any multiple of it, on every device [byte].
constexpr uint64_t kSdfRangeAlignment = 256;

/// Sizes [bytes] of the buffers that an SDF needs for itself; keys and surface may be shared.
struct SdfBufferSizes {
  uint64_t keys = 0, surface = 0;
  uint64_t counts = 0;  ///< persistent when the field is built incrementally
  uint64_t points = 0, work = 0, marks = 0;
  uint64_t votes = 0;  ///< scratch of a build of three axes
};
SdfBufferSizes sdfBufferSizes(const SdfBuildDef& def);

/// kInvalid if the definition does not need the buffer.
struct SdfBuildBuffers {
  BufferId vertices = BufferId::kInvalid;
  BufferId pointVertices = BufferId::kInvalid, indices = BufferId::kInvalid;
  BufferId neighbors = BufferId::kInvalid, fanStarts = BufferId::kInvalid;
  BufferId fans = BufferId::kInvalid;
  BufferId keys = BufferId::kInvalid, surface = BufferId::kInvalid;
  BufferId counts = BufferId::kInvalid, points = BufferId::kInvalid;
  BufferId work = BufferId::kInvalid;  ///< BufferUsage: storage, indirect and upload
  BufferId marks = BufferId::kInvalid, votes = BufferId::kInvalid;
};

/// The data of the last build that the next one needs.
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

/// Words of the work buffer that count the work of a build.
struct SdfBuildCounters {
  /// Bytes into the work buffer.
  static constexpr uint64_t kOffset = sdf_work::kWorkBigCount * sizeof(uint32_t);
  uint32_t bigTriangles = 0;    ///< that were shared by groups
  uint32_t interiorNodes = 0;   ///< coarse nodes that fill_interior gave a triangle
  uint32_t movedPoints = 0;     ///< incremental builds: vertices that moved
  uint32_t movedTriangles = 0;  ///< incremental builds, but of three axes
  uint32_t clearedBricks = 0;   ///< likewise
};

/// Adds the passes of one build. In an incremental build the GPU starts all passes but the first,
/// with no groups if nothing moved. Errors: those of PassBuilder::finish().
Result<void> addSdfBuild(PassList& list, const ResourceTable& resources,
                         const SdfBuildBuffers& buffers, const SdfBuildDef& def, SdfBuildMode mode,
                         SdfBuildState& state);

}  // namespace pelage::detail
