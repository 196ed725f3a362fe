// Resources that strands are sorted into tiles of the screen in. Group "strandTiles" (space2 behind
// RenderPosTan and Render).
#ifndef PELAGE_LAYOUTS_STRAND_TILES_HLSLI
#define PELAGE_LAYOUTS_STRAND_TILES_HLSLI

cbuffer StrandTilesConstants : register(b0, space2) {
  uint g_binWidth;          // [pixels]
  uint g_binHeight;         // [pixels]
  uint g_binTileColumns;    // tiles of 8 x 8 pixels in a row
  uint g_binTileCount;
  uint g_binRecordCount;    // of all objects
  uint g_binFirstRecord;    // of this object
  uint g_binObjectRecords;  // of this object
  uint g_binCapacity;       // references that there is room for
};

// [vertex][3], see oit/tiles/strand_record.hlsli.
RWStructuredBuffer<uint4> g_binRecords : register(u0, space2);
// [tile] segments in it; [tile] where its references begin, after the last step where they end;
// behind both the tiles that have some, in order.
RWStructuredBuffer<uint> g_binTiles : register(u1, space2);
// Places of segments' first records.
RWStructuredBuffer<uint> g_binReferences : register(u2, space2);
// [block of 128 tiles]: x references, y tiles that have some; then those of the blocks before.
RWStructuredBuffer<uint2> g_binSums : register(u3, space2);
// See oit/tiles/strand_tile_counters.hlsli.
RWStructuredBuffer<uint> g_binCounters : register(u4, space2);

#endif
