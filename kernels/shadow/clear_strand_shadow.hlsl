// Empties a shadow map.
//
// Threads: one per texel, in rows of 2^20.
// Reads:   g_shadowViews
// Writes:  the depths of g_shadowWords; splat_strand_depths empties the layers
//
// Invariant (tests/shadow): every texel of the map is without hair, and no other word changes.
#include "shadow_segment.hlsli"

[numthreads(128, 1, 1)]
void clear_strand_shadow(uint3 thread : SV_DispatchThreadID) {
  StrandShadowView map = g_shadowViews[g_shadowView];
  uint index = indexOfThread(thread);
  uint texels = map.width * map.height;
  if (!isShadowView(map) || index >= texels * map.faceCount) return;
  g_shadowWords[shadowFace(map, index / texels).firstWord + index % texels] = kNoHair;
}
