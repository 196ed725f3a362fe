// ShortCut, first pass: finds the three nearest depths of each pixel, by the cascade of
// nearest_depths.hlsli, and the transmittance of all fragments.
//
// Reads:   RenderConstants, StrandViewConstants, ShortCutDepthsAlphaConstants
// Writes:  g_shortCutDepths, g_shortCutTiles, g_shortCutCounters
//
// Invariant (tests/oit): every fragment of alpha > 0 counts, however thin its coverage (K39).
#include "../shading/layouts/render.hlsli"
#include "layouts/short_cut_depths_alpha.hlsli"
#include "../shading/strand_alpha.hlsli"
#include "layer_packing.hlsli"
#include "spill_tail.hlsli"
#define TILE_FLAGS g_shortCutTiles
#define TILE_COUNTERS g_shortCutCounters
#define LAYER_DEPTHS g_shortCutDepths
#include "nearest_depths.hlsli"

[earlydepthstencil]
void short_cut_depths_alpha(StrandPixel strand) {
  // Always true; Vulkan's layers warn of outputs of a vertex kernel that are not read.
  if (!(dot(strand.tangent, strand.tangent) >= 0.0)) return;
  uint alpha = layerAlphaOf(strandAlpha(strand));
  if (alpha == 0u) return;
  uint pixel = layerPixel(strand.clip.xy, g_viewport.xy, g_shortCutWidth, g_shortCutHeight);
  if (pixel == kNoPixel) return;
  markTile(uint2(pixel % g_shortCutWidth, pixel / g_shortCutWidth), g_shortCutTileColumns,
           g_shortCutHeight);
  InterlockedAdd(g_shortCutDepths[4u * pixel + 3u], opticalDepthOf(squared(alpha, 255u)));
  insertDepth(4u * pixel, 3u, layerKey(strand.clip.z, g_reversedDepth != 0u));
}
