// Empties a shadow map.
//
// Threads: one per word, in rows of 2^20.
// Reads:   g_shadowViews
// Writes:  g_shadowWords
//
// Invariant (tests/shadow): every texel of the map is without hair, and no other word changes.
#include "shadow_segment.hlsli"

[numthreads(128, 1, 1)]
void clear_strand_shadow(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_shadowWordCount) return;
  StrandShadowView map = g_shadowViews[g_shadowView];
  if (!isShadowView(map)) return;
  uint stride = 1u + map.layerCount;
  g_shadowWords[map.firstWord + index] = index % stride == 0u ? kNoHair : 0u;
}
