// Adds up the layers of a shadow map: each gets the optical depth up to its own end.
//
// Threads: one per texel, in rows of 2^20.
// Reads:   g_shadowViews
// Writes:  the layers of g_shadowWords
//
// Invariant (tests/shadow): layers do not decrease with the distance, and the last one has the sum.
#include "shadow_segment.hlsli"

[numthreads(64, 1, 1)]
void accumulate_strand_shadow(uint3 thread : SV_DispatchThreadID) {
  StrandShadowView map = g_shadowViews[g_shadowView];
  uint index = indexOfThread(thread);
  uint texels = map.width * map.height;
  if (!isShadowView(map) || index >= texels * map.faceCount) return;
  map = shadowFace(map, index / texels);
  uint texel = index % texels;
  if (g_shadowWords[map.firstWord + texel] == kNoHair) return;
  uint first = firstLayerOf(map, texel);
  uint sum = 0u;
  for (uint layer = 0u; layer < map.layerCount; ++layer) {
    sum += g_shadowWords[first + layer];
    g_shadowWords[first + layer] = sum;
  }
}
