// Resources of a slice through an SDF, group "slice".
#ifndef VIEWER_SLICE_HLSLI
#define VIEWER_SLICE_HLSLI

static const uint kSliceColors = 5;

cbuffer SliceConstants : register(b0, space0) {
  float4 g_sliceToClip[4];  // rows; clip = rows * (p, 1), p in world space, depth 0..1, y up
  float4 g_sliceRamp[5];    // linear rgb of distances from g_sliceLow to g_sliceHigh, evenly
  float4 g_sliceCorner;     // xyz of the rectangle [m]
  float4 g_sliceAcross;     // xyz along its edges [m]
  float4 g_sliceUp;
  float4 g_sliceOrigin;  // xyz of node 0 in world space, w cell size [m]
  uint4 g_sliceNodes;    // xyz counts
  float g_sliceLow;      // [m]
  float g_sliceHigh;
  float g_sliceLine;      // distance between lines [m]
  uint g_sliceSlotCount;  // of g_sliceSlots
};

StructuredBuffer<uint4> g_sliceSlots : register(t0, space0);  // HairBuffers::sdfs
StructuredBuffer<uint> g_sliceKeys : register(t1, space0);    // Scene::sdfKeys()

struct SliceVaryings {
  float4 clip : SV_Position;
  float3 world : TEXCOORD0;  // [m]
};

#endif
