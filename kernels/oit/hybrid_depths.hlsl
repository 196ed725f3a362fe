// Finds the nearest depths of each pixel, by the cascade of nearest_depths.hlsli.
//
// Reads:   RenderConstants, StrandViewConstants, HybridDepthsConstants
// Writes:  g_hybridDepths, g_hybridTiles, g_hybridCounters
//
// Invariant (tests/oit): the keys of the nearest fragments of alpha > 0, in order; equal keys each
// have a slot.
#include "layouts/hybrid_depths.hlsli"
#include "../shading/layouts/render.hlsli"
#include "../shading/strand_alpha.hlsli"
#include "layer_packing.hlsli"
#define TILE_FLAGS g_hybridTiles
#define TILE_COUNTERS g_hybridCounters
#define LAYER_DEPTHS g_hybridDepths
#include "nearest_depths.hlsli"

[earlydepthstencil]
void hybrid_depths(StrandPixel strand) {
  // Always true; Vulkan's layers warn of outputs of a vertex kernel that are not read.
  if (!(dot(strand.tangent, strand.tangent) >= 0.0)) return;
  if (layerAlphaOf(strandAlpha(strand)) == 0u) return;
  uint pixel = layerPixel(strand.clip.xy, g_viewport.xy, g_hybridWidth, g_hybridHeight);
  if (pixel == kNoPixel) return;
  uint key = layerKey(strand.clip.z, g_reversedDepth != 0u);
  uint first = g_hybridLayers * pixel;
  // All slots have nearer or equal keys.
  if (g_hybridDepths[first + g_hybridLayers - 1u] <= key) return;
  markTile(uint2(pixel % g_hybridWidth, pixel / g_hybridWidth), g_hybridTileColumns,
           g_hybridHeight);
  insertDepth(first, g_hybridLayers, key);
}
