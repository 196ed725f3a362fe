// Adds up the fragments of tiles, and of 128 tiles.
//
// Threads: one per tile.
// Reads:   g_binPixels
// Writes:  g_binTiles, g_binSums
#include "strand_tile_sums.hlsli"

[numthreads(128, 1, 1)]
void sum_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tile = group.x * 128u + lane;
  uint count = 0u;
  if (tile < g_binTileCount) {
    for (uint i = 0u; i < 64u; ++i) {
      uint fragments = g_binPixels[64u * tile + i];
      count = fragments > 0xffffffffu - count ? 0xffffffffu : count + fragments;
    }
    g_binTiles[tile] = count;
  }
  uint2 all = sumUpTo(lane, uint2(count, count > 0u ? 1u : 0u));
  if (lane == 127u) g_binSums[group.x] = all;
}
