// Resources for finding the three nearest depths of each pixel. Group "shortCutDepthsAlpha" (space2
// after RenderPosTan and Render).
#ifndef PELAGE_OIT_LAYOUTS_SHORT_CUT_DEPTHS_ALPHA_HLSLI
#define PELAGE_OIT_LAYOUTS_SHORT_CUT_DEPTHS_ALPHA_HLSLI

cbuffer ShortCutDepthsAlphaConstants : register(b0, space2) {
  uint g_shortCutWidth;        // [pixels]
  uint g_shortCutHeight;       // [pixels]
  uint g_shortCutTileColumns;  // tiles of 8 x 8 pixels in a row
  uint g_shortCutPad0;
};

// [y][x][4]: the three nearest depth keys, see oit/nearest_depths.hlsli; then the optical depth of
// all fragments, as word 3 of oit/spill_tail.hlsli.
RWStructuredBuffer<uint> g_shortCutDepths : register(u0, space2);
// As in oit/ppll_counters.hlsli, without nodes.
RWStructuredBuffer<uint> g_shortCutCounters : register(u1, space2);
// [tile]: 1 if it has hair; after them a list of these tiles, in any order.
RWStructuredBuffer<uint> g_shortCutTiles : register(u2, space2);
// g_shortCutColors of short_cut_fill_colors, to be cleared.
RWStructuredBuffer<uint> g_shortCutClearedColors : register(u3, space2);

#endif
