// Resources of the kernels that build an SDF. Group "generateSdf", all in space0.
//
// Lengths are in cells and positions are relative to node 0, except for g_sdfVertices. A "point" is
// a distinct position of vertices; triangles are counted by the host's topology.
#ifndef PELAGE_SDF_LAYOUTS_GENERATE_SDF_HLSLI
#define PELAGE_SDF_LAYOUTS_GENERATE_SDF_HLSLI

cbuffer GenerateSdfConstants : register(b0, space0) {
  // Groups of the dispatches that an incremental build starts on the GPU; first: decision 0008.
  uint g_triangleGroups;    // x of find_moved_triangles and scatter_triangles
  uint g_surfaceGroups;     // x of update_surface
  uint g_rowGroups;         // x of finalize_sdf
  uint g_clearGroups;       // x of clear_sdf
  uint g_columnGroups;      // x of count_sdf_columns
  uint g_coarseGroups;      // x of fill_interior
  float g_motionTolerance;  // a vertex that moved less since it was built keeps its position
  uint g_buildFlags;        // kSdfIncremental, kSdfThreeAxes
  // As in Sdf.
  float4 g_sdfOrigin;
  uint4 g_sdfNodes;
  uint g_sdfTriangleCount;
  uint g_sdfTriangleBits;
  uint g_contactSdfSurface;
  uint g_sdfSurfaceStride;
  float g_sdfBand;
  float g_sdfFarRange;
  uint g_vertexStride;  // of g_sdfVertices, in floats
  uint g_vertexOffset;  // of the first one's x, in floats
  uint g_vertexCount;
  uint g_pointCount;
  uint g_pointSlot;       // 0 or 1: the half of g_sdfPoints that is written; the other one is
                          // what the last build wrote
  uint g_buildStamp;      // another number > 0 in every build
  float4 g_historyShift;  // xyz: what to add to the points of the last build; w = 1 when there
                          // are any, else 0
};

// Builds only what moved; a mesh of three axes is built as a whole if anything moved.
static const uint kSdfIncremental = 1;
// Signs by the vote of three axes: the mesh is open, or its parts overlap.
static const uint kSdfThreeAxes = 2;

// An engine's vertex buffer, positions in the space of the SDF [m].
StructuredBuffer<float> g_sdfVertices : register(t0, space0);
// [point] one of its vertices.
StructuredBuffer<uint> g_sdfPointVertices : register(t1, space0);
// [triangle][corner] point.
StructuredBuffer<uint> g_sdfIndices : register(t2, space0);
// [triangle][edge] triangle across the edges 01, 12, 20, or kSdfNone.
StructuredBuffer<uint> g_sdfNeighbors : register(t3, space0);
// [point] first of its elements of g_sdfFans, and one more at the end.
StructuredBuffer<uint> g_sdfFanStarts : register(t4, space0);
// For each corner at the point: the points of the next and the previous corner of its triangle.
StructuredBuffer<uint2> g_sdfFans : register(t5, space0);

// [2][point]: xyz; w = 1, or 0 where the vertex is not finite.
RWStructuredBuffer<float4> g_sdfPoints : register(u0, space0);
RWStructuredBuffer<uint> g_sdfKeys : register(u1, space0);
// [axis][node / 4]: crossings, a signed byte a node with the borrow of the bytes below it; axes y
// and z with kSdfThreeAxes.
RWStructuredBuffer<uint> g_sdfCounts : register(u2, space0);
RWStructuredBuffer<uint4> g_sdfSurface : register(u3, space0);
// sdf_work.hlsli has the layout.
RWStructuredBuffer<uint> g_sdfWork : register(u4, space0);
// [brick of 4^3 nodes, x fastest] the last build that cleared it; then [point] the last build in
// which it or a neighbor moved.
RWStructuredBuffer<uint> g_sdfMarks : register(u5, space0);
// [axis y, z][node / 4]: one byte per node, the axis' vote on it: voteOf() in sdf_counts.hlsli.
RWStructuredBuffer<uint> g_sdfVotes : register(u6, space0);

#endif
