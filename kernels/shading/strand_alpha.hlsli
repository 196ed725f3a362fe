// Coverage of a pixel by a fragment of a smooth ribbon.
#ifndef PELAGE_SHADING_STRAND_ALPHA_HLSLI
#define PELAGE_SHADING_STRAND_ALPHA_HLSLI

#include "strand_common.hlsli"

#define SMOOTH 1
#include "strand_interface.hlsli"

// Returns the opacity of the fiber times its share of the pixel, 0..1.
float strandAlpha(StrandPixel strand) {
  float w = strand.ribbon.z;
  float2 ribbon = abs(w) > 1e-20 ? strand.ribbon.xy / w : float2(0.0, 0.0);
  return saturate(strand.color.a * ribbonCoverage(ribbon.x, ribbon.y));
}

#endif
