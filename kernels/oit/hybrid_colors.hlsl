// Lights the fragments of hair: those of the nearest depths into their layers, the others into the
// pixel's tail.
//
// Reads:   RenderConstants, StrandViewConstants, HybridColorsConstants, g_foundDepths,
//          g_shadowWords
// Writes:  g_hybridColors, g_hybridTail
//
// Invariant (tests/oit): every fragment of alpha > 0 is in one layer or in the tail.
#include "../shading/layouts/render.hlsli"
#include "../shading/strand_alpha.hlsli"
#include "layer_packing.hlsli"
#include "spill_tail.hlsli"

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

#define LAYER_DEPTHS g_foundDepths
#define LAYER_COLORS g_hybridColors
#include "nearest_depths.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "../shading/light_strand.hlsli"
#include "../shading/pixel_surface.hlsli"

[earlydepthstencil]
void hybrid_colors(StrandPixel strand) {
  uint alpha = layerAlphaOf(strandAlpha(strand));
  if (alpha == 0u) return;
  uint pixel = layerPixel(strand.clip.xy, g_viewport.xy, g_colorsWidth, g_colorsHeight);
  if (pixel == kNoPixel) return;
  uint key = layerKey(strand.clip.z, g_reversedDepth != 0u);
  float3 light = lightStrand(renderShading(), pixelSurface(strand, saturate(strand.color.rgb)));
  uint layer = packLayer(light, alpha);

  // The first key that is not nearer; their number is a power of two.
  uint first = g_colorsLayers * pixel;
  uint index = 0u;
  for (uint step = g_colorsLayers >> 1; step > 0u; step >>= 1) {
    if (g_foundDepths[first + index + step - 1u] < key) index += step;
  }
  uint left = insertLayer(first, first, index, g_colorsLayers, key, layer);
  if (left == 0u) return;
  uint4 tail = tailOf(lightOfLayer(left), alphaOfLayer(left));
  InterlockedAdd(g_hybridTail[4u * pixel], tail.x);
  InterlockedAdd(g_hybridTail[4u * pixel + 1u], tail.y);
  InterlockedAdd(g_hybridTail[4u * pixel + 2u], tail.z);
  InterlockedAdd(g_hybridTail[4u * pixel + 3u], tail.w);
}
