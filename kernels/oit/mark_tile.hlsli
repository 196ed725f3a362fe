// Puts the tile of a pixel on the list of those that have hair. Who includes this defines before
//   TILE_FLAGS     the RWStructuredBuffer<uint> of the tiles, flags and list
//   TILE_COUNTERS  that of the counters, see ppll_counters.hlsli
#ifndef PELAGE_OIT_MARK_TILE_HLSLI
#define PELAGE_OIT_MARK_TILE_HLSLI

#include "ppll_counters.hlsli"

void markTile(uint2 at, uint columns, uint height) {
  uint tile = (at.y >> 3) * columns + (at.x >> 3);
  if (TILE_FLAGS[tile] != 0u) return;
  uint before;
  InterlockedExchange(TILE_FLAGS[tile], 1u, before);
  if (before != 0u) return;
  uint place;
  InterlockedAdd(TILE_COUNTERS[kCounterTiles], 1u, place);
  TILE_FLAGS[columns * ((height + 7u) >> 3) + place] = tile;
}

#endif
