// The composite of layers, for the kernels that resolve them.
#ifndef PELAGE_OIT_LAYER_COMPOSITE_HLSLI
#define PELAGE_OIT_LAYER_COMPOSITE_HLSLI

#include "layer_packing.hlsli"
#include "nearest_depths.hlsli"
#include "spill_tail.hlsli"

struct LayerComposite {
  float3 light;
  float transmittance;
};

// An empty layer adds nothing.
void addLayer(inout LayerComposite sum, uint layer) {
  float alpha = alphaOfLayer(layer);
  sum.light += lightOfLayer(layer) * (sum.transmittance * alpha);
  sum.transmittance *= 1.0 - alpha;
}

#endif
