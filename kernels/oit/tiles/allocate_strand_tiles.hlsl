// Computes the offset of each pixel's fragments, and lists the tiles that have some. A tile whose
// fragments do not all fit gets none: otherwise the ones that fit would depend on their order of
// arrival.
//
// Threads: one per tile.
// Reads:   g_binPixels, g_binTiles, g_binSums
// Writes:  g_binPixels, g_binTiles
#include "strand_tile_counters.hlsli"
#include "strand_tile_sums.hlsli"

bool hasRoom(uint begin, uint end) {
  uint round = begin / g_binRoundSpan;
  return round < g_binRoundCount && end - round * g_binRoundSpan <= g_binCapacity;
}

[numthreads(128, 1, 1)]
void allocate_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tile = group.x * 128u + lane;
  uint2 own = sumOfTile(tile);
  uint2 behind = saturatingSum(g_binSums[group.x], sumUpTo(lane, own));
  if (own.y == 0u) return;
  g_binTiles[2u * g_binTileCount + behind.y - 1u] = tile;
  uint begin = behind.x - own.x;
  if (!hasRoom(begin, behind.x)) {
    g_binTiles[tile] = 0u;
    g_binTiles[g_binTileCount + tile] = kNoTileOffset;
    return;
  }
  g_binTiles[g_binTileCount + tile] = begin;
  for (uint first = 64u * tile; first < 64u * tile + 64u; first += 8u) {
    uint counts[8];
    [unroll] for (uint i = 0u; i < 8u; ++i) counts[i] = g_binPixels[first + i];
    [unroll] for (uint j = 0u; j < 8u; ++j) {
      g_binPixels[first + j] = begin;
      begin += counts[j];
    }
  }
}
