// Fragments and layers into words and back. One thread a sample; groups of 64.
#include "packing_samples.hlsli"
#include "../../../kernels/oit/layer_packing.hlsli"
#include "../../../kernels/oit/tiles/strand_tile_fragment.hlsli"

[numthreads(64, 1, 1)]
void pack_samples(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_packingCount) return;
  PackingSample s = g_packingSamples[id.x];
  bool reversed = g_packingReversed != 0u;
  PackingResult result;
  result.shape = packShape(s.tangent.xyz, s.color.w);
  result.colorWord = packColor(s.color.xyz);
  result.color = float4(colorOf(result.colorWord), alphaOfShape(result.shape));
  result.tangent =
      float4(tangentOfShape(result.shape), depthOfKey(depthKey(s.tangent.w, reversed), reversed));
  uint alpha = layerAlphaOf(s.color.w);
  result.layer = packLayer(s.color.xyz, alpha);
  result.light = float4(lightOfLayer(result.layer), alphaOfLayer(result.layer));
  result.layerAgain = packLayer(result.light.xyz, alpha);
  result.tileBits = 24u + (id.x & 7u);
  TileFragment fragment;
  fragment.key = depthKey(s.tangent.w, reversed);
  fragment.root = roundedRoot(saturate(s.color.w), kTileRoots);
  fragment.segment = asuint(s.color.x) & ((1u << result.tileBits) - 1u);
  fragment = unpackTileFragment(packTileFragment(fragment, result.tileBits), result.tileBits);
  result.tileKey = fragment.key;
  result.tileRoot = fragment.root;
  result.tileSegment = fragment.segment;
  g_packingResults[id.x] = result;
}
