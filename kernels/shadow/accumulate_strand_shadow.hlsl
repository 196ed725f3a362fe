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
  if (!isShadowView(map) || index >= map.width * map.height * map.faceCount) return;
  uint word = map.firstWord + index * (1u + map.layerCount);
  if (g_shadowWords[word] == kNoHair) return;
  uint sum = 0u;
  for (uint layer = 1; layer <= map.layerCount; ++layer) {
    sum += g_shadowWords[word + layer];
    g_shadowWords[word + layer] = sum;
  }
}
