// ShortCut, second pass: writes the third nearest depth of a pixel, so that the fragments behind it
// fail the depth test of the next pass before they are lit.
//
// Reads:   ShortCutResolveDepthConstants, g_thirdDepths
// Writes:  SV_Depth
#include "layouts/oit_tiles.hlsli"
#include "layer_composite.hlsli"

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

// The depth is written this far behind the fragment, so that it passes the test in targets of 16
// bits, and if the test rounds the depth differently from the kernel. Fragments in between are lit
// and then found not to be among the three.
static const float kDepthMargin = 1.5 / 65535.0;

struct DepthPixel {
  float depth : SV_Depth;
};

DepthPixel short_cut_resolve_depth(OitTilePixel tile) {
  DepthPixel result;
  result.depth = 0.0;
  uint pixel = layerPixel(tile.clip.xy, g_thirdOrigin, g_thirdWidth, g_thirdHeight);
  if (pixel == kNoPixel) discard;
  uint third = g_thirdDepths[pixel == kNoPixel ? 0u : pixel].z;
  // With fewer than three fragments there is nothing behind.
  if (third == kNoDepth) discard;
  bool reversed = g_thirdReversed != 0u;
  float depth = depthOfKey(third, reversed);
  result.depth = saturate(reversed ? depth - kDepthMargin : depth + kDepthMargin);
  return result;
}
