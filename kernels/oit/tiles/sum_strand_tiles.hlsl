// Adds up the references of 128 tiles.
//
// Threads: one per tile.
// Reads:   g_binTiles
// Writes:  g_binSums
#include "strand_tile_sums.hlsli"

[numthreads(128, 1, 1)]
void sum_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint2 own = sumOfTile(group.x * 128u + lane);
  uint2 all = sumUpTo(lane, own);
  if (lane == 127u) g_binSums[group.x] = all;
}
