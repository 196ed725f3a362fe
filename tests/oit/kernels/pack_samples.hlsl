// Fragments and layers into words and back. One thread a sample; groups of 64.
#include "packing_samples.hlsli"
#include "../../../kernels/oit/layer_packing.hlsli"

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
  g_packingResults[id.x] = result;
}
