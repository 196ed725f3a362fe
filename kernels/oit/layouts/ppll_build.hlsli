// Resources for building a per-pixel linked list. Groups "ppllBuild" (space2 after RenderPosTan and
// Render).
#ifndef PELAGE_OIT_LAYOUTS_PPLL_BUILD_HLSLI
#define PELAGE_OIT_LAYOUTS_PPLL_BUILD_HLSLI

cbuffer PPLLBuildConstants : register(b0, space2) {
  uint g_listWidth;   // [pixels]
  uint g_listHeight;  // [pixels]
  uint g_nodeCapacity;
  uint g_listTileColumns;  // tiles of 8 x 8 pixels in a row
};

// [y][x]: index of the pixel's first node + 1, or 0.
RWStructuredBuffer<uint> g_listHeads : register(u0, space2);
// {link, depth key, shape, color}, see oit/fragment_packing.hlsli; with STRAND_UV then [node] the
// UV of roots, see shading/uv_packing.hlsli.
RWStructuredBuffer<uint4> g_listNodes : register(u1, space2);
// See oit/ppll_counters.hlsli.
RWStructuredBuffer<uint> g_listCounters : register(u2, space2);
// [tile]: 1 if it has hair; after them a list of these tiles, in any order.
RWStructuredBuffer<uint> g_listTiles : register(u3, space2);
// [y][x][4]: fragments without a node, see oit/spill_tail.hlsli; only with the tail permutation.
RWStructuredBuffer<uint> g_listTail : register(u4, space2);

#endif
