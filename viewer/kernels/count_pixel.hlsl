// Counts a fragment of hair that nothing opaque hides.
//
// Reads:   ValueVaryings, DrawValuesConstants
// Writes:  g_overdraw
//
// Invariant (viewer_test): the sum over all pixels is the number of fragments, in any order.
#include "overdraw.hlsli"
#include "strand_value.hlsli"

[earlydepthstencil]
void count_pixel(ValueVaryings strand) {
  if (!(abs(strand.value) < kMostValue)) return;
  int2 at = int2(strand.clip.xy) - int2(g_valueArea.xy);
  if (at.x < 0 || at.y < 0 || at.x >= int(g_valueArea.z) || at.y >= int(g_valueArea.w)) return;
  uint before;
  InterlockedAdd(g_overdraw[uint(at.y) * uint(g_valueArea.z) + uint(at.x)], 1u, before);
}
