// Resources of showing how much hair the tiles of a transparency method have, group "tileCounts"
// (space1 after DrawValues).
#ifndef VIEWER_TILE_COUNTS_HLSLI
#define VIEWER_TILE_COUNTS_HLSLI

#include "draw_values.hlsli"
#include "oit/pixel_tiles.hlsli"

cbuffer TileCountsConstants : register(b0, space1) {
  uint g_tileColumns;  // tiles in a row
  uint g_tileCount;    // of the view
  uint g_tileWidth;    // of the view [pixels]
  uint g_tileNodes;    // nodes of lists
};

// TransparencyTiles: tiles, counters, heads, nodes. A buffer that a method lacks is a stand-in.
StructuredBuffer<uint> g_tileWords : register(t0, space1);
StructuredBuffer<uint> g_tileCounters : register(t1, space1);
StructuredBuffer<uint> g_tileHeads : register(t2, space1);
StructuredBuffer<uint4> g_tileListNodes : register(t3, space1);

RWStructuredBuffer<uint> g_tileCounts : register(u0, space1);   // [tile], or kTileWithoutRoom
RWStructuredBuffer<uint> g_tileSummary : register(u1, space1);  // kTileWords

// A tile whose hair exceeded the capacity.
static const uint kTileWithoutRoom = 0xffffffffu;

static const uint kTileMost = 0;  // of the fullest tile
static const uint kTilesWithHair = 1;
static const uint kTileTotal = 2;  // of all tiles
static const uint kTilesWithoutRoom = 3;
static const uint kTileWords = 4;

#endif
