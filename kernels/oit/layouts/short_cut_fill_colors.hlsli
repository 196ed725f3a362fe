// Resources for coloring the three nearest fragments of each pixel. Group "shortCutFillColors"
// (space2 after RenderPosTan and Render).
#ifndef PELAGE_OIT_LAYOUTS_SHORT_CUT_FILL_COLORS_HLSLI
#define PELAGE_OIT_LAYOUTS_SHORT_CUT_FILL_COLORS_HLSLI

cbuffer ShortCutFillColorsConstants : register(b0, space2) {
  uint g_fillWidth;   // [pixels]
  uint g_fillHeight;  // [pixels]
  uint g_fillPad0;
  uint g_fillPad1;
};

// As g_shortCutDepths.
StructuredBuffer<uint> g_fillDepths : register(t0, space2);
// [y][x][3]: color and alpha of the fragment of that depth, or 0; see oit/layer_packing.hlsli.
RWStructuredBuffer<uint> g_shortCutColors : register(u0, space2);

#endif
