// Light of 1 / pi from all directions that a strand sends to the eye: the sum over one circle of
// directions around the fiber, weighted with their solid angles. One thread a sample and circle;
// groups of 64. The sample's light is not read.
#include "shade_samples.hlsli"

[numthreads(64, 1, 1)]
void sum_light(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_shadeCount * g_thetaCount) return;
  ShadeSample s = g_shadeSamples[id.x / g_thetaCount];
  StrandShading material = materialOf(s);
  StrandSurface surface = surfaceOf(s);
  float step = kShadingPi / float(g_thetaCount);
  float turn = 2.0 * kShadingPi / float(g_phiCount);
  float theta = (float(id.x % g_thetaCount) + 0.5) * step - 0.5 * kShadingPi;
  float3 side = shadingNormal(surface.tangent, surface.toEye);
  float3 other = cross(surface.tangent, side);
  float3 sum = float3(0.0, 0.0, 0.0);
  for (uint i = 0u; i < g_phiCount; ++i) {
    float phi = (float(i) + 0.5) * turn;
    float3 light = surface.tangent * sin(theta) + (side * cos(phi) + other * sin(phi)) * cos(theta);
    sum += shadeStrand(material, surface, light);
  }
  g_shaded[id.x] = float4(sum * (cos(theta) * step * turn / kShadingPi), 0.0);
}
