// Reads the transmittance at points from a shadow map, or its mean for skin.
#include "shading/layouts/strand_shadow_view.hlsli"

cbuffer ReadShadowConstants : register(b0, space0) {
  uint g_readCount;
  uint g_readView;
  uint g_readSoft;  // 1: softTransmittance()
  uint g_readPad0;
};
StructuredBuffer<float4> g_readPoints : register(t0, space0);
StructuredBuffer<uint> g_readWords : register(t1, space0);
StructuredBuffer<StrandShadowView> g_readViews : register(t2, space0);
RWStructuredBuffer<float> g_readResults : register(u0, space0);

#define SHADOW_WORDS g_readWords
#include "shading/strand_shadow.hlsli"

[numthreads(64, 1, 1)]
void read_strand_shadow(uint3 thread : SV_DispatchThreadID) {
  if (thread.x >= g_readCount) return;
  float3 position = g_readPoints[thread.x].xyz;
  g_readResults[thread.x] = g_readSoft != 0u
                                ? softTransmittance(g_readViews[g_readView], position)
                                : strandTransmittance(g_readViews[g_readView], position);
}
