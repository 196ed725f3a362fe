// Resources of the collision of vertices with signed distance fields. Group "applySdf", all in
// space0.
#ifndef PELAGE_LAYOUTS_APPLY_SDF_HLSLI
#define PELAGE_LAYOUTS_APPLY_SDF_HLSLI

#include "sdf_field.hlsli"

cbuffer ApplySdfConstants : register(b0, space0) {
  uint g_sdfVertexCount;
  uint g_sdfFieldCount;
  float g_sdfBegin;  // share of the frame at which the vertices are where they were before, 0..1
  float g_sdfEnd;    // share at which they are where they are now
};

// [vertex]: xyz in the space of the fields' origins [m]; w = inverse mass, > 0 for a free one.
RWStructuredBuffer<float4> g_sdfPositions : register(u0, space0);
// [vertex]: xyz a step before [m]; what they are apart is the velocity. w unused.
RWStructuredBuffer<float4> g_sdfPositionsBefore : register(u1, space0);
// [g_sdfFieldCount]
StructuredBuffer<SdfField> g_sdfFields : register(t0, space0);
StructuredBuffer<uint> g_sdfKeys : register(t1, space0);
StructuredBuffer<uint4> g_sdfSurface : register(t2, space0);

#endif
