// Resources of marching cubes. Group "sdfMarchingCubes", all in space0.
//
// N nodes and R = ny * nz rows of them along x, of the field at hand.
#ifndef PELAGE_LAYOUTS_SDF_MARCHING_CUBES_HLSLI
#define PELAGE_LAYOUTS_SDF_MARCHING_CUBES_HLSLI

#include "iso_vertex.hlsli"
#include "sdf_field.hlsli"

cbuffer MarchingCubesConstants : register(b0, space0) {
  uint g_marchingField;     // index into g_marchingFields
  float g_isoLevel;         // [cell], of magnitude below the field's band
  uint g_vertexCapacity;    // of g_isoVertices
  uint g_triangleCapacity;  // of g_isoIndices / 3
  uint g_rowCapacity;       // of g_isoRows
  uint g_nodeCapacity;      // of g_isoNodes
  uint g_fieldCapacity;     // of g_marchingFields
  uint g_keyCapacity;       // of g_marchingKeys
};

// What came out, for the host.
struct MarchingCounts {
  uint vertices;   // that the surface has
  uint triangles;  // that it has
  uint overflow;   // bits: 1 more vertices than there is room for, 2 more triangles, 4 the field is
                   // not inside the buffers or is larger than marching_cubes.hlsli can number: no
                   // surface
  uint pad0;
};

// All fields of a scene.
StructuredBuffer<SdfField> g_marchingFields : register(t0, space0);
// Their keys.
StructuredBuffer<uint> g_marchingKeys : register(t1, space0);
// [R]: x vertices, y triangles that begin in the row, and then the sums of the rows before it.
RWStructuredBuffer<uint2> g_isoRows : register(u0, space0);
// [N]: what begins at a node, see marching_cubes.hlsli.
RWStructuredBuffer<uint> g_isoNodes : register(u1, space0);
// [1]
RWStructuredBuffer<MarchingCounts> g_isoCounts : register(u2, space0);
// [g_vertexCapacity]
RWStructuredBuffer<IsoVertex> g_isoVertices : register(u3, space0);
// [3 * g_triangleCapacity]: the triangles, and 0 behind them.
RWStructuredBuffer<uint> g_isoIndices : register(u4, space0);

#endif
