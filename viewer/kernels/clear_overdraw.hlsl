// Clears the counters of fragments, and their summary.
//
// Threads: one per pixel, in rows of kInspectRow; kOverdrawWords at least.
// Writes:  g_overdraw, g_overdrawSummary
//
// Invariant (viewer_test): the counts of a frame do not depend on the last one.
#include "overdraw.hlsli"
#include "strand_value.hlsli"

[numthreads(64, 1, 1)]
void clear_overdraw(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index < kOverdrawWords) g_overdrawSummary[index] = 0u;
  if (index < overdrawPixels()) g_overdraw[index] = 0u;
}
