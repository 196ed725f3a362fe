// Light that reaches points, without shadows: color, and its ratio to the light at 1 m.
#include "shading/strand_lighting.hlsli"

cbuffer ReadIlluminationConstants : register(b0, space0) {
  float4 g_litDirection;  // members of StrandLight
  float4 g_litColor;
  float4 g_litCone;
  uint g_litCount;
  uint g_litPad0;
  uint g_litPad1;
  uint g_litPad2;
};
StructuredBuffer<float4> g_litPoints : register(t0, space0);
RWStructuredBuffer<float4> g_litResults : register(u0, space0);

[numthreads(64, 1, 1)]
void read_illumination(uint3 thread : SV_DispatchThreadID) {
  if (thread.x >= g_litCount) return;
  StrandLight light;
  light.direction = g_litDirection;
  light.color = g_litColor;
  light.shadow = uint4(kNoStrandShadow, 0u, 0u, 0u);
  light.cone = g_litCone;
  StrandIllumination arriving = strandIllumination(light, g_litPoints[thread.x].xyz);
  g_litResults[thread.x] = float4(arriving.color, 1.0);
}
