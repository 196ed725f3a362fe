// ShortCut, fourth pass: composites the three nearest fragments of a pixel; the rest has their mean
// color and the remaining transmittance.
//
// Reads:   ShortCutResolveColorConstants, g_frontDepths, g_frontColors
// Writes:  SV_Target0 premultiplied color, alpha = 1 - transmittance
//
// Invariant (tests/oit): the exact composite if a pixel has no more than three fragments; its
// transmittance everywhere. A pixel without fragments does not change: nothing is divided by 0
// (K39).
#include "layouts/oit_tiles.hlsli"
#include "layer_composite.hlsli"

cbuffer ShortCutResolveColorConstants : register(b0, space1) {
  float2 g_frontOrigin;  // offset of the viewport [pixels]
  uint g_frontWidth;     // [pixels]
  uint g_frontHeight;    // [pixels]
};

// As g_shortCutDepths, four words in one.
StructuredBuffer<uint4> g_frontDepths : register(t0, space1);
// As g_shortCutColors.
StructuredBuffer<uint> g_frontColors : register(t1, space1);

ResolvedPixel short_cut_resolve_color(OitTilePixel tile) {
  ResolvedPixel result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  uint pixel = layerPixel(tile.clip.xy, g_frontOrigin, g_frontWidth, g_frontHeight);
  if (pixel == kNoPixel) discard;
  uint index = pixel == kNoPixel ? 0u : pixel;
  LayerComposite sum;
  sum.light = float3(0.0, 0.0, 0.0);
  sum.transmittance = 1.0;
  uint seen = 0u;
  for (uint i = 0u; i < 3u; ++i) {
    uint layer = g_frontColors[3u * index + i];
    addLayer(sum, layer);
    seen += layer != 0u ? opticalDepthOf(alphaOfLayer(layer)) : 0u;
  }
  float covered = 1.0 - sum.transmittance;
  if (!(covered > 0.0)) discard;
  uint total = g_frontDepths[index].w;
  float behind = transmittanceOf(total - min(seen, total));
  float all = 1.0 - sum.transmittance * behind;
  result.color = float4(sum.light * (all / max(covered, 1e-6)), all);
  return result;
}
