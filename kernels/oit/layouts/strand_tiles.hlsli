// Resources for sorting the fragments of strands by pixel. Group "strandTiles".
#ifndef PELAGE_OIT_LAYOUTS_STRAND_TILES_HLSLI
#define PELAGE_OIT_LAYOUTS_STRAND_TILES_HLSLI

cbuffer StrandTilesConstants : register(b0, space0) {
  uint g_binWidth;        // [pixels]
  uint g_binHeight;       // [pixels]
  uint g_binTileColumns;  // tiles of 8 x 8 pixels in a row
  uint g_binTileCount;
  uint g_binRecordCount;  // of all objects
  uint g_binCapacity;     // fragments that a round has room for
  uint g_binRoundSpan;    // tiles whose offsets are in one such range have one round
  uint g_binRoundCount;
  uint g_binRoundBegin;     // offset at which the round begins
  uint g_binReversedDepth;  // 0 or 1
  uint g_binSegmentBits;    // see packTileFragment()
  uint g_binPad0;
};

// [vertex][3], see shading/strand_record.hlsli.
StructuredBuffer<uint4> g_binRecords : register(t0, space0);
// [y][x]: depth of opaque objects; only with the occluded permutation.
StructuredBuffer<float> g_binDepth : register(t1, space0);
// [tile][64 pixels]: number of fragments; then the offset of the pixel's fragments, and after the
// round the end of these.
RWStructuredBuffer<uint> g_binPixels : register(u0, space0);
// [tile] number of fragments, 0 where they have no room; [tile] their offset, kNoTileOffset without
// room; then a list of the tiles that have hair, in order.
RWStructuredBuffer<uint> g_binTiles : register(u1, space0);
// [block of 128 tiles]: x fragments, y tiles that have some; later the prefix sums of the blocks.
// Then one of x: fragments of the round that are visible, y: all tiles that have some.
RWStructuredBuffer<uint2> g_binSums : register(u2, space0);
// See oit/tiles/strand_tile_counters.hlsli.
RWStructuredBuffer<uint> g_binCounters : register(u3, space0);
// [fragment of the round], see oit/tiles/strand_tile_fragment.hlsli.
RWStructuredBuffer<uint2> g_binFragments : register(u4, space0);

uint binBlocks() { return (g_binTileCount + 127u) / 128u; }

#endif
