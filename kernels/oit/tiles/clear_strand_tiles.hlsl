// Empties all tiles.
//
// Threads: one per tile.
// Writes:  g_binTiles
#include "../layouts/strand_tiles.hlsli"

[numthreads(128, 1, 1)]
void clear_strand_tiles(uint tile : SV_DispatchThreadID) {
  if (tile >= g_binTileCount) return;
  g_binTiles[tile] = 0u;
  g_binTiles[g_binTileCount + tile] = 0u;
}
