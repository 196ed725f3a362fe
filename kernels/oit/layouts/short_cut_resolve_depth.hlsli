// Resources for writing the third depth of each pixel. Group "shortCutResolveDepth", space1 after
// OitTiles.
#ifndef PELAGE_OIT_LAYOUTS_SHORT_CUT_RESOLVE_DEPTH_HLSLI
#define PELAGE_OIT_LAYOUTS_SHORT_CUT_RESOLVE_DEPTH_HLSLI

cbuffer ShortCutResolveDepthConstants : register(b0, space1) {
  float2 g_thirdOrigin;  // offset of the viewport [pixels]
  uint g_thirdWidth;     // [pixels]
  uint g_thirdHeight;    // [pixels]
  uint g_thirdReversed;  // 1 with reversed depth
  uint g_thirdPad0;
  uint g_thirdPad1;
  uint g_thirdPad2;
};

// As g_shortCutDepths, four words in one.
StructuredBuffer<uint4> g_thirdDepths : register(t0, space1);

#endif
