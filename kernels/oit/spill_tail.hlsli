// Sums for the fragments of a pixel without a node or layer: integers, so that the order of arrival
// does not matter. Lists add base colors and light the mean; layers add lit colors.
//
//   words 0..2  sum of w x linear color, in units of 1 / kTailScale
//   word 3      sum of w = -log2(1 - alpha), in units of 1 / kTailScale
//
// Their transmittance is exact up to that rounding; their color is the mean, weighted by w (after
// the weighted averages of Bavoil and Myers, "Order independent transparency with dual depth
// peeling", 2008, with w instead of alpha, which needs no further word). 8,000 fragments with both
// values at their maximum fit into a word.
#ifndef PELAGE_OIT_SPILL_TAIL_HLSLI
#define PELAGE_OIT_SPILL_TAIL_HLSLI

static const float kTailScale = 8192.0;
static const float kTailMaxAlpha = 0.996;
static const float kTailMaxColor = 8.0;

// Contribution of one fragment to word 3. An alpha above 0 is never rounded to 0.
uint opticalDepthOf(float alpha) {
  float depth = -log2(1.0 - clamp(alpha, 0.0, kTailMaxAlpha)) * kTailScale;
  return max(uint(depth + 0.5), 1u);
}

float transmittanceOf(uint opticalDepth) { return exp2(-float(opticalDepth) / kTailScale); }

// Contribution of one fragment.
uint4 tailOf(float3 color, float alpha) {
  uint weight = opticalDepthOf(alpha);
  float3 light = min(max(color, 0.0), kTailMaxColor) * float(weight) + 0.5;
  return uint4(uint3(light), weight);
}

// Premultiplied light, and the transmittance.
float4 tailLight(uint4 tail) {
  float transmittance = transmittanceOf(tail.w);
  float3 mean = float3(tail.xyz) / max(float(tail.w), 1.0);
  return float4(mean * (1.0 - transmittance), transmittance);
}

#endif
