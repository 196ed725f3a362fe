// shadeStrandInHair() for a light of 1, and with g_phiCount 1 volumeAmbient() for light of 1 from all
// sides. One thread a sample; groups of 64. Of the sample, the w of toEye, base and light are front,
// behind and across of StrandLightPath; front < 0 is a light without a map.
#include "shade_samples.hlsli"

[numthreads(64, 1, 1)]
void shade_volume(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_shadeCount) return;
  ShadeSample s = g_shadeSamples[id.x];
  StrandShading material = materialOf(s);
  StrandSurface surface = surfaceOf(s);
  StrandLightPath path;
  path.known = true;
  path.front = s.toEye.w;
  path.behind = s.base.w;
  path.across = s.light.w;
  path.transmittance = exp(-path.front);
  if (path.front < 0.0) path = openLightPath();
  StrandVolume volume = strandVolumeOf(material, surface);
  float3 shaded = float3(0.0, 0.0, 0.0);
  if (g_phiCount == 1u) {
    shaded = volumeAmbient(volume, path, dot(surface.toEye, s.light.xyz), float3(1.0, 1.0, 1.0),
                           float3(0.0, 0.0, 0.0));
  } else {
    shaded = shadeStrandInHair(material, surface, s.light.xyz, volume, path);
  }
  g_shaded[id.x] = float4(shaded, 0.0);
}
