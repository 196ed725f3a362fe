// Resources for finding the nearest depths of each pixel. Group "hybridDepths" (space2 after
// RenderPosTan and Render).
#ifndef PELAGE_OIT_LAYOUTS_HYBRID_DEPTHS_HLSLI
#define PELAGE_OIT_LAYOUTS_HYBRID_DEPTHS_HLSLI

cbuffer HybridDepthsConstants : register(b0, space2) {
  uint g_hybridWidth;        // [pixels]
  uint g_hybridHeight;       // [pixels]
  uint g_hybridLayers;       // fragments that a pixel keeps: 4, 8 or 16
  uint g_hybridTileColumns;  // tiles of 8 x 8 pixels in a row
};

// [y][x][layer]: depth keys, the nearest first; see oit/nearest_depths.hlsli.
RWStructuredBuffer<uint> g_hybridDepths : register(u0, space2);
// As in oit/ppll_counters.hlsli, without nodes.
RWStructuredBuffer<uint> g_hybridCounters : register(u1, space2);
// [tile]: 1 if it has hair; after them a list of these tiles, in any order.
RWStructuredBuffer<uint> g_hybridTiles : register(u2, space2);
// g_hybridColors and g_hybridTail of hybrid_colors, to be cleared.
RWStructuredBuffer<uint> g_hybridClearedColors : register(u3, space2);
RWStructuredBuffer<uint> g_hybridClearedTail : register(u4, space2);

#endif
