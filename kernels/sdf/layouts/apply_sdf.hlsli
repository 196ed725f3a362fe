// Resources of the collision of vertices with SDFs. Group "applySdf", all in
// space0.
#ifndef PELAGE_SDF_LAYOUTS_APPLY_SDF_HLSLI
#define PELAGE_SDF_LAYOUTS_APPLY_SDF_HLSLI

#include "sdf.hlsli"

cbuffer ApplySdfConstants : register(b0, space0) {
  uint g_sdfVertexCount;
  uint g_sdfCount;
  float g_sdfBegin;  // fraction of the frame of the previous positions, 0..1
  float g_sdfEnd;    // fraction of the frame of the current positions
};

// [vertex]: xyz in the space of the SDFs' origins [m]; w = inverse mass, > 0 for a free one.
RWStructuredBuffer<float4> g_sdfPositions : register(u0, space0);
// [vertex]: xyz position one step earlier [m]; the difference is the velocity. w unused.
RWStructuredBuffer<float4> g_sdfPositionsBefore : register(u1, space0);
// [g_sdfCount]
StructuredBuffer<Sdf> g_sdfs : register(t0, space0);
StructuredBuffer<uint> g_sdfKeys : register(t1, space0);
StructuredBuffer<uint4> g_sdfSurface : register(t2, space0);

#endif
