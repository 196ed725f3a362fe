// Resources of marching cubes. Group "sdfMarchingCubes", all in space0.
//
// N nodes and R = ny * nz rows of them along x, of the current SDF.
#ifndef PELAGE_SDF_LAYOUTS_SDF_MARCHING_CUBES_HLSLI
#define PELAGE_SDF_LAYOUTS_SDF_MARCHING_CUBES_HLSLI

#include "sdf.hlsli"

cbuffer MarchingCubesConstants : register(b0, space0) {
  uint g_marchingSdf;       // index into g_marchingSdfs
  float g_isoLevel;         // [cell], of magnitude below the SDF's band
  uint g_vertexCapacity;    // of g_isoVertices
  uint g_triangleCapacity;  // of g_isoIndices / 3
  uint g_rowCapacity;       // of g_isoRows
  uint g_nodeCapacity;      // of g_isoNodes
  uint g_sdfCapacity;       // of g_marchingSdfs
  uint g_keyCapacity;       // of g_marchingKeys
};

struct IsoVertex {
  float4 position;  // xyz in the space of the SDF [m]; w = 1
  float4 normal;    // xyz unit vector to where the distance grows; w = 0
};

// The result, for the host.
struct MarchingCounts {
  uint vertices;   // of the surface
  uint triangles;  // of the surface
  uint overflow;   // bits: 1 too many vertices for the capacity, 2 too many triangles, 4 the SDF is
                   // not inside the buffers or is larger than marching_cubes.hlsli can number: no
                   // surface
  uint pad0;
};

// All SDFs of a scene.
StructuredBuffer<Sdf> g_marchingSdfs : register(t0, space0);
// Their keys.
StructuredBuffer<uint> g_marchingKeys : register(t1, space0);
// [R]: x vertices, y triangles that begin in the row; later the prefix sums of the rows.
RWStructuredBuffer<uint2> g_isoRows : register(u0, space0);
// [N]: the elements of a node, see marching_cubes.hlsli.
RWStructuredBuffer<uint> g_isoNodes : register(u1, space0);
// [1]
RWStructuredBuffer<MarchingCounts> g_isoCounts : register(u2, space0);
// [g_vertexCapacity]
RWStructuredBuffer<IsoVertex> g_isoVertices : register(u3, space0);
// [3 * g_triangleCapacity]: the triangles, then zeros.
RWStructuredBuffer<uint> g_isoIndices : register(u4, space0);

#endif
