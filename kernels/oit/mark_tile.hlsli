// Adds the tile of a pixel to the list of tiles with hair. The including file first defines
//   TILE_FLAGS     the RWStructuredBuffer<uint> of the tiles, flags and list
//   TILE_COUNTERS  that of the counters, see ppll_counters.hlsli
#ifndef PELAGE_OIT_MARK_TILE_HLSLI
#define PELAGE_OIT_MARK_TILE_HLSLI

#include "pixel_tiles.hlsli"
#include "ppll_counters.hlsli"

void markTile(uint2 at, uint columns, uint height) {
  uint tile = (at.y >> kTileShift) * columns + (at.x >> kTileShift);
  if (TILE_FLAGS[tile] != 0u) return;
  uint before;
  InterlockedExchange(TILE_FLAGS[tile], 1u, before);
  if (before != 0u) return;
  uint index;
  InterlockedAdd(TILE_COUNTERS[kCounterTiles], 1u, index);
  TILE_FLAGS[columns * ((height + (kTileEdge - 1u)) >> kTileShift) + index] = tile;
}

#endif
