// Computes the offset of each tile's references, and lists the tiles that have some. A tile whose
// references do not all fit gets none: otherwise the ones that fit would depend on their order of
// arrival.
//
// Threads: one per tile.
// Reads:   g_binTiles, g_binSums
// Writes:  g_binTiles
#include "strand_tile_sums.hlsli"

[numthreads(128, 1, 1)]
void allocate_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tile = group.x * 128u + lane;
  uint2 own = sumOfTile(tile);
  uint2 behind = saturatingSum(g_binSums[group.x], sumUpTo(lane, own));
  if (own.y == 0u) return;
  g_binTiles[2u * g_binTileCount + behind.y - 1u] = tile;
  bool fits = behind.x <= g_binCapacity;
  if (!fits) g_binTiles[tile] = 0u;
  g_binTiles[g_binTileCount + tile] = fits ? behind.x - own.x : 0u;
}
