// Adds fragments of hair to a pixel, from front to back. The including file has a layout with
// strand_view.hlsli and includes shading/light_strand.hlsli before.
#ifndef PELAGE_OIT_COMPOSITE_FRAGMENT_HLSLI
#define PELAGE_OIT_COMPOSITE_FRAGMENT_HLSLI

#include "fragment_packing.hlsli"

struct Composite {
  float3 light;  // premultiplied
  float transmittance;
};

Composite emptyComposite() {
  Composite sum;
  sum.light = float3(0.0, 0.0, 0.0);
  sum.transmittance = 1.0;
  return sum;
}

// \param at center of the pixel in the viewport, row 0 the top row [pixels]
StrandSurface surfaceOfFragment(float2 at, uint key, uint shape, uint color, float2 uv) {
  float3 position = fragmentPosition(at, depthOfKey(key, g_reversedDepth != 0u));
  StrandSurface surface = strandSurface(position, tangentOfShape(shape), colorOf(color));
  surface.uv = uv;
  return surface;
}

// Words as in fragment_packing.hlsli. \param uv of the root, 0 where it is not kept
void addFragment(inout Composite sum, StrandShading material, float2 at, uint key, uint shape,
                 uint color, float2 uv) {
  float alpha = alphaOfShape(shape);
  float3 light = lightStrand(material, surfaceOfFragment(at, key, shape, color, uv));
  sum.light += light * (sum.transmittance * alpha);
  sum.transmittance *= 1.0 - alpha;
}

#endif
