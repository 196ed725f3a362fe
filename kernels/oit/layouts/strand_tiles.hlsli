// Resources for sorting strands into tiles of the screen. Group "strandTiles".
#ifndef PELAGE_OIT_LAYOUTS_STRAND_TILES_HLSLI
#define PELAGE_OIT_LAYOUTS_STRAND_TILES_HLSLI

cbuffer StrandTilesConstants : register(b0, space0) {
  uint g_binWidth;        // [pixels]
  uint g_binHeight;       // [pixels]
  uint g_binTileColumns;  // tiles of 8 x 8 pixels in a row
  uint g_binTileCount;
  uint g_binRecordCount;  // of all objects
  uint g_binCapacity;     // capacity for references
  uint g_binPad0;
  uint g_binPad1;
};

// [vertex][3], see shading/strand_record.hlsli.
StructuredBuffer<uint4> g_binRecords : register(t0, space0);
// [tile] number of segments; [tile] offset of its references, after the last step their end; then a
// list of the tiles that have some, in order.
RWStructuredBuffer<uint> g_binTiles : register(u0, space0);
// Indices of segments' first records.
RWStructuredBuffer<uint> g_binReferences : register(u1, space0);
// [block of 128 tiles]: x references, y tiles that have some; later the prefix sums of the blocks.
RWStructuredBuffer<uint2> g_binSums : register(u2, space0);
// See oit/tiles/strand_tile_counters.hlsli.
RWStructuredBuffer<uint> g_binCounters : register(u3, space0);

#endif
