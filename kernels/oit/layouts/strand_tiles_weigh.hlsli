// Resources for finding the visible fragments of pixels, and for adding up their light. Group
// "strandTilesWeigh".
#ifndef PELAGE_OIT_LAYOUTS_STRAND_TILES_WEIGH_HLSLI
#define PELAGE_OIT_LAYOUTS_STRAND_TILES_WEIGH_HLSLI

cbuffer StrandTilesWeighConstants : register(b0, space0) {
  uint g_weighWidth;        // [pixels]
  uint g_weighHeight;       // [pixels]
  uint g_weighTileColumns;  // tiles in a row
  uint g_weighTileCount;
  uint g_weighRoundSpan;  // as in strand_tiles.hlsli
  uint g_weighRoundBegin;
  float g_weighEpsilon;     // transmittance that counts as none, 0..1
  uint g_weighSegmentBits;  // as in strand_tiles.hlsli
};

// As in strand_tiles.hlsli.
StructuredBuffer<uint4> g_weighRecords : register(t0, space0);
StructuredBuffer<uint> g_weighPixels : register(t1, space0);
StructuredBuffer<uint> g_weighTiles : register(t2, space0);
StructuredBuffer<uint2> g_weighFragments : register(t3, space0);
// Pairs of words.
RWStructuredBuffer<uint> g_weighSums : register(u0, space0);
// [visible fragment], a pixel's one after the other: segment as TileFragment has it, pixel
// y * width + x, optical depth in front of the fragment, and its own. shade_strand_tiles leaves
// the premultiplied light that arrives at the eye as three floats, and the optical depth.
RWStructuredBuffer<uint4> g_weighVisible : register(u1, space0);
// [y][x]: index of the first visible fragment and their number; then premultiplied color and
// 1 - transmittance as four halves. Of the tiles that have hair.
RWStructuredBuffer<uint2> g_weighPicture : register(u2, space0);

// The index behind the sums of blocks: of the number of visible fragments, the tiles that have hair, and
// the pixels of a group.
uint weighSumsEnd() { return 2u * ((g_weighTileCount + 127u) / 128u); }

#endif
