// Sums over tiles: x fragments, y tiles that have some. Fragments saturate.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_SUMS_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_SUMS_HLSLI

#include "../layouts/strand_tiles.hlsli"

groupshared uint2 s_sums[128];

uint2 saturatingSum(uint2 a, uint2 b) {
  return uint2(b.x > 0xffffffffu - a.x ? 0xffffffffu : a.x + b.x, a.y + b.y);
}

uint2 sumOfTile(uint tile) {
  uint2 sum = uint2(0u, 0u);
  if (tile < g_binTileCount) {
    uint count = g_binTiles[tile];
    sum = uint2(count, count > 0u ? 1u : 0u);
  }
  return sum;
}

// Returns the sum over the lanes up to this one. All 128 lanes call it.
uint2 sumUpTo(uint lane, uint2 own) {
  s_sums[lane] = own;
  GroupMemoryBarrierWithGroupSync();
  for (uint range = 1u; range < 128u; range *= 2u) {
    uint2 others = uint2(0u, 0u);
    if (lane >= range) others = s_sums[lane - range];
    GroupMemoryBarrierWithGroupSync();
    s_sums[lane] = saturatingSum(s_sums[lane], others);
    GroupMemoryBarrierWithGroupSync();
  }
  return s_sums[lane];
}

#endif
