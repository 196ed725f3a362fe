// Resources for coloring the nearest fragments of each pixel. Group "hybridColors" (space2 after
// RenderPosTan and Render).
#ifndef PELAGE_OIT_LAYOUTS_HYBRID_COLORS_HLSLI
#define PELAGE_OIT_LAYOUTS_HYBRID_COLORS_HLSLI

cbuffer HybridColorsConstants : register(b0, space2) {
  uint g_colorsWidth;   // [pixels]
  uint g_colorsHeight;  // [pixels]
  uint g_colorsLayers;  // fragments that a pixel keeps: 4, 8 or 16
  uint g_colorsPad0;
};

// As g_hybridDepths.
StructuredBuffer<uint> g_foundDepths : register(t0, space2);
// [y][x][layer]: color and alpha of the fragment of that depth, or 0; see oit/layer_packing.hlsli.
RWStructuredBuffer<uint> g_hybridColors : register(u0, space2);
// [y][x][4]: the fragments behind the layers, see oit/spill_tail.hlsli.
RWStructuredBuffer<uint> g_hybridTail : register(u1, space2);

#endif
