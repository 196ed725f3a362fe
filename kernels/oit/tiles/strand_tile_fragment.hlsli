// A fragment of a strand, as the kernels of tiles have it: its place in a list of its pixel, its
// segment, its depth key, and its optical depth. Optical depths are sums of integers, which no order
// of strands changes: units of 2^-20, to the base 2.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_FRAGMENT_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_FRAGMENT_HLSLI

static const float kOpticalUnit = 1048576.0;
// What no light comes through.
static const float kOpaqueDepth = 32.0;

// \param alpha 0..1 \return at least 1 for an alpha of fragment_packing.hlsli that is not 0
uint opticalDepthOf(float alpha) {
  float through = 1.0 - alpha;
  return uint((through > 0.0 ? min(-log2(through), kOpaqueDepth) : kOpaqueDepth) * kOpticalUnit +
              0.5);
}

float transmittanceOfDepth(uint depth) { return exp2(float(depth) * (-1.0 / kOpticalUnit)); }

// The optical depth behind which nothing is looked for. \param epsilon transmittance, 0..1
uint opticalCut(float epsilon) {
  return uint(clamp(-log2(max(epsilon, 1e-9)), 0.0, 30.0) * kOpticalUnit + 0.5);
}

#endif
