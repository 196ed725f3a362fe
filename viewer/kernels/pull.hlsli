// Resources of pull_hair, group "pull".
#ifndef VIEWER_PULL_HLSLI
#define VIEWER_PULL_HLSLI

cbuffer PullConstants : register(b0, space0) {
  uint g_pullVertexCount;
  float g_pullStiffness;  // [1/s2]
  float g_pullDamping;    // [1/s]
  float g_pullLimit;      // largest acceleration [m/s2]
  float4 g_pullDrag;      // xyz: how far the mouse has dragged [m]; w unused
};

// [guide][vertex]: world position [m]; w unused.
StructuredBuffer<float4> g_pullPositions : register(t0, space0);
// [guide][vertex]: xyz position when the hair was taken [m]; w: weight, 0..1.
StructuredBuffer<float4> g_pullTaken : register(t1, space0);
// [guide][vertex]: xyz acceleration [m/s2], w drag [1/s].
RWStructuredBuffer<float4> g_pullForces : register(u0, space0);

#endif
