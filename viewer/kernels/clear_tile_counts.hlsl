// Clears the counts of all tiles, and their summary.
//
// Threads: one per tile, in rows of kInspectRow; kTileWords at least.
// Writes:  g_tileCounts, g_tileSummary
//
// Invariant (viewer_test): the counts of a frame do not depend on the last one.
#include "strand_value.hlsli"
#include "tile_counts.hlsli"

[numthreads(64, 1, 1)]
void clear_tile_counts(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index < kTileWords) g_tileSummary[index] = 0u;
  if (index < g_tileCount) g_tileCounts[index] = 0u;
}
