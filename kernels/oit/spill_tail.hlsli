// Where the fragments of a pixel go that found no room: sums of integers, so that their order of
// arrival does not matter. Lists add base colours and light their mean, layers add lit ones.
//
//   words 0..2  sum of w x linear colour, in units of 1 / kTailScale
//   word 3      sum of w = -log2(1 - alpha), in units of 1 / kTailScale
//
// Their transmittance is exact but for that rounding; their colour is the mean, weighted by w
// (after the weighted averages of Bavoil and Myers, "Order independent transparency with dual depth
// peeling", 2008, with w in place of alpha: it needs no word of its own).
#ifndef PELAGE_OIT_SPILL_TAIL_HLSLI
#define PELAGE_OIT_SPILL_TAIL_HLSLI

static const float kTailScale = 8192.0;
static const float kTailMaxAlpha = 0.996;
// 8,000 fragments of both maxima fit into a word.
static const float kTailMaxColor = 8.0;

// What one fragment adds to word 3. An alpha above 0 is never rounded away.
uint opticalDepthOf(float alpha) {
  float depth = -log2(1.0 - clamp(alpha, 0.0, kTailMaxAlpha)) * kTailScale;
  return max(uint(depth + 0.5), 1u);
}

float transmittanceOf(uint opticalDepth) { return exp2(-float(opticalDepth) / kTailScale); }

// What one fragment adds.
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
