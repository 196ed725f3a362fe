// ShortCut, third pass: lights the three nearest fragments of each pixel.
//
// Reads:   RenderConstants, StrandViewConstants, ShortCutFillColorsConstants, g_fillDepths,
//          g_shadowWords
// Writes:  g_shortCutColors
#include "../shading/layouts/render.hlsli"
#include "../shading/strand_alpha.hlsli"
#include "layer_packing.hlsli"

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

#define LAYER_DEPTHS g_fillDepths
#define LAYER_COLORS g_shortCutColors
#include "nearest_depths.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "../shading/light_strand.hlsli"
#include "../shading/pixel_surface.hlsli"

[earlydepthstencil]
void short_cut_fill_colors(StrandPixel strand) {
  uint alpha = layerAlphaOf(strandAlpha(strand));
  if (alpha == 0u) return;
  uint pixel = layerPixel(strand.clip.xy, g_viewport.xy, g_fillWidth, g_fillHeight);
  if (pixel == kNoPixel) return;
  uint key = layerKey(strand.clip.z, g_reversedDepth != 0u);
  uint3 keys =
      uint3(g_fillDepths[4u * pixel], g_fillDepths[4u * pixel + 1u], g_fillDepths[4u * pixel + 2u]);
  // The first key that is not nearer. Not a loop: with a loop that invocations leave at different
  // iterations, llvmpipe of Mesa 22.3 found the wrong index.
  uint index = (keys.x < key ? 1u : 0u) + (keys.y < key ? 1u : 0u) + (keys.z < key ? 1u : 0u);
  if (keys.x != key && keys.y != key && keys.z != key) return;
  float3 light = lightStrand(renderShading(), pixelSurface(strand, saturate(strand.color.rgb)));
  // Fragments of one depth beyond the slots only count by their transmittance.
  insertLayer(4u * pixel, 3u * pixel, index, 3u, key, packLayer(light, alpha));
}
