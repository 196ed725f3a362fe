// Resources that a per-pixel linked list is built in. Groups "ppllBuild" (space2 behind
// RenderPosTan and Render).
#ifndef PELAGE_LAYOUTS_PPLL_BUILD_HLSLI
#define PELAGE_LAYOUTS_PPLL_BUILD_HLSLI

cbuffer PPLLBuildConstants : register(b0, space2) {
  uint g_listWidth;   // [pixels]
  uint g_listHeight;  // [pixels]
  uint g_nodeCapacity;
  uint g_listTileColumns;  // tiles of 8 x 8 pixels in a row
};

// [y][x]: place of the pixel's first node + 1, or 0.
RWStructuredBuffer<uint> g_listHeads : register(u0, space2);
// {link, depth key, shape, color}, see oit/fragment_packing.hlsli.
RWStructuredBuffer<uint4> g_listNodes : register(u1, space2);
// See oit/ppll_counters.hlsli.
RWStructuredBuffer<uint> g_listCounters : register(u2, space2);
// [tile]: 1 where it has hair; behind them the tiles that have some, in any order.
RWStructuredBuffer<uint> g_listTiles : register(u3, space2);
// [y][x][4]: fragments that found no room, see oit/spill_tail.hlsli; only with the tail permutation.
RWStructuredBuffer<uint> g_listTail : register(u4, space2);

#endif
