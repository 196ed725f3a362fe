// Composites the layers of a pixel from front to back, then its tail.
//
// Reads:   HybridReadConstants, g_layerColors, g_layerTail
// Writes:  SV_Target0 premultiplied color, alpha = 1 - transmittance
//
// Invariant (tests/oit): the composite of all fragments in order if a pixel has no more of them
// than layers; otherwise its transmittance, with the mean color of those behind the layers.
#include "layouts/oit_tiles.hlsli"
#include "layer_composite.hlsli"

cbuffer HybridReadConstants : register(b0, space1) {
  float2 g_layersOrigin;  // offset of the viewport [pixels]
  uint g_layersWidth;     // [pixels]
  uint g_layersHeight;    // [pixels]
  uint g_layersQuads;     // a quarter of the fragments that a pixel keeps
  uint g_layersPad0;
  uint g_layersPad1;
  uint g_layersPad2;
};

// g_hybridColors and g_hybridTail of hybrid_colors, four words in one.
StructuredBuffer<uint4> g_layerColors : register(t0, space1);
StructuredBuffer<uint4> g_layerTail : register(t1, space1);

ResolvedPixel hybrid_read(OitTilePixel tile) {
  ResolvedPixel result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  uint pixel = layerPixel(tile.clip.xy, g_layersOrigin, g_layersWidth, g_layersHeight);
  if (pixel == kNoPixel) discard;
  uint index = pixel == kNoPixel ? 0u : pixel;
  LayerComposite sum;
  sum.light = float3(0.0, 0.0, 0.0);
  sum.transmittance = 1.0;
  for (uint i = 0u; i < g_layersQuads; ++i) {
    uint4 layers = g_layerColors[g_layersQuads * index + i];
    if (all(layers == uint4(0u, 0u, 0u, 0u))) break;
    addLayer(sum, layers.x);
    addLayer(sum, layers.y);
    addLayer(sum, layers.z);
    addLayer(sum, layers.w);
  }
  float4 tail = tailLight(g_layerTail[index]);
  sum.light += tail.rgb * sum.transmittance;
  sum.transmittance *= tail.a;
  if (sum.transmittance == 1.0) discard;
  result.color = float4(sum.light, 1.0 - sum.transmittance);
  return result;
}
