// Reads the transmittance at points from a depth map of opaque geometry.
#include "shading/layouts/opaque_shadow_view.hlsli"

cbuffer ReadOpaqueConstants : register(b0, space0) {
  float4 g_opaqueToLight;  // xyz unit vector
  uint g_opaquePointCount;
  uint g_readOpaquePad0;
  uint g_readOpaquePad1;
  uint g_readOpaquePad2;
};
StructuredBuffer<float4> g_opaquePoints : register(t0, space0);
StructuredBuffer<uint> g_opaqueMapWords : register(t1, space0);
StructuredBuffer<OpaqueShadowView> g_opaqueViews : register(t2, space0);
RWStructuredBuffer<float> g_opaqueResults : register(u0, space0);

#define SHADOW_WORDS g_opaqueMapWords
#include "shading/opaque_shadow.hlsli"

[numthreads(64, 1, 1)]
void read_opaque_shadow(uint3 thread : SV_DispatchThreadID) {
  if (thread.x >= g_opaquePointCount) return;
  g_opaqueResults[thread.x] =
      opaqueTransmittance(g_opaqueViews[0], g_opaquePoints[thread.x].xyz, g_opaqueToLight.xyz);
}
