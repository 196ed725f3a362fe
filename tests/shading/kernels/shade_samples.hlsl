// shadeStrand() for a light of 1, in w strandAmbient() of red. One thread a sample; groups of 64.
#include "shade_samples.hlsli"

[numthreads(64, 1, 1)]
void shade_samples(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_shadeCount) return;
  ShadeSample s = g_shadeSamples[id.x];
  StrandShading material = materialOf(s);
  StrandSurface surface = surfaceOf(s);
  StrandLight light;
  light.direction = s.light;
  light.color = float4(1.0, 1.0, 1.0, 0.0);
  light.shadow = uint4(kNoStrandShadow, 0u, 0u, 0u);
  light.cone = float4(0.0, 0.0, 0.0, 0.0);
  StrandIllumination arriving = strandIllumination(light, surface.position);
  float3 shaded = arriving.color * shadeStrand(material, surface, arriving.toLight);
  g_shaded[id.x] = float4(shaded, strandAmbient(material, surface).x);
}
