// ribbonCoverage() of pixels. One thread a pixel; groups of 64.
#include "ribbon_samples.hlsli"

[numthreads(64, 1, 1)]
void cover_pixels(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_ribbonCount) return;
  float2 s = g_pixelSamples[id.x];
  g_pixelCoverage[id.x] = ribbonCoverage(s.x, s.y);
}
