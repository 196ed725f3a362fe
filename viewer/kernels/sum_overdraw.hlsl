// Sums the counters of fragments: the fullest pixel, pixels with hair, and all fragments.
//
// Threads: one per pixel, in rows of kInspectRow.
// Reads:   g_overdraw
// Writes:  g_overdrawSummary
//
// Invariant (viewer_test): pixels with hair <= fragments.
#include "overdraw.hlsli"
#include "strand_value.hlsli"

[numthreads(64, 1, 1)]
void sum_overdraw(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= overdrawPixels()) return;
  uint count = g_overdraw[index];
  if (count == 0u) return;
  uint before;
  InterlockedMax(g_overdrawSummary[kOverdrawMost], count, before);
  InterlockedAdd(g_overdrawSummary[kOverdrawPixels], 1u, before);
  InterlockedAdd(g_overdrawSummary[kOverdrawTotal], count, before);
}
