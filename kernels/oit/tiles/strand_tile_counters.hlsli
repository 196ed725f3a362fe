// Words of the counters of tiles of strands. Draws, dispatches and hosts read them.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_COUNTERS_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_COUNTERS_HLSLI

// 0..3 are the arguments of the draw of tiles: vertices, instances, 0, 0.
static const uint kTileDrawWord = 0u;
static const uint kTileInstancesWord = 1u;
// Number of references that segments requested.
static const uint kTileReferencesWord = 4u;
// 5..7 are the arguments of the dispatch of the composite: groups.
static const uint kTileDispatchWord = 5u;

// Groups of the composite in a row.
static const uint kTileDispatchRow = 1024u;

#endif
