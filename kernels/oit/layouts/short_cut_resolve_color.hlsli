// Resources for compositing three fragments of each pixel. Group "shortCutResolveColor", space1
// after OitTiles.
#ifndef PELAGE_OIT_LAYOUTS_SHORT_CUT_RESOLVE_COLOR_HLSLI
#define PELAGE_OIT_LAYOUTS_SHORT_CUT_RESOLVE_COLOR_HLSLI

cbuffer ShortCutResolveColorConstants : register(b0, space1) {
  float2 g_frontOrigin;  // offset of the viewport [pixels]
  uint g_frontWidth;     // [pixels]
  uint g_frontHeight;    // [pixels]
};

// As g_shortCutDepths, four words in one.
StructuredBuffer<uint4> g_frontDepths : register(t0, space1);
// As g_shortCutColors.
StructuredBuffer<uint> g_frontColors : register(t1, space1);

#endif
