// Words of the counters of tiles of strands. Draws, dispatches and hosts read them.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_COUNTERS_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_COUNTERS_HLSLI

// 0..3 are the arguments of the draw of tiles: vertices, instances, 0, 0.
static const uint kTileDrawWord = 0u;
static const uint kTileInstancesWord = 1u;
// Number of fragments that segments have.
static const uint kTileFragmentsWord = 4u;
// 5..7 are the arguments of dispatches over tiles: groups.
static const uint kTileDispatchWord = 5u;

// Tiles in a row of these groups.
static const uint kTileDispatchRow = 1024u;

// Pixels of a group of weigh_strand_tiles and gather_strand_tiles. It takes those of many fragments one
// after the other: where few tiles have many, as of far hair, each group takes one pixel.
static const uint kMostPixels = 16u;
static const uint kManyFragments = 768u;  // of a tile
static const uint kFewTiles = 1024u;

uint pixelsOfGroup(uint fragments, uint tiles) {
  return tiles <= kFewTiles && fragments / kManyFragments >= tiles ? 1u : kMostPixels;
}

// Offset of a tile whose fragments have no room.
static const uint kNoTileOffset = 0xffffffffu;

#endif
