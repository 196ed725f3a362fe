// A lit fragment in one word, for methods with a fixed number of layers:
//   sqrt(alpha) 8 bits | exponent 3 | b 7 | g 7 | r 7
// The channels share the exponent: the largest is at most 2^(exponent - 3), so that colors up to 16
// keep seven bits of their largest channel. All values are rounded to nearest. 0 means no fragment:
// an alpha above 0 never becomes 0.
//
// Invariant (tests/oit): the round trip of a word gives that word, or, for colors that a smaller
// exponent can also store, one of the same value.
#ifndef PELAGE_OIT_LAYER_PACKING_HLSLI
#define PELAGE_OIT_LAYER_PACKING_HLSLI

#include "fragment_packing.hlsli"

static const float kDimmestLayer = 0.125;
static const float kBrightestLayer = 16.0;

uint layerAlphaOf(float alpha) { return alpha > 0.0 ? max(roundedRoot(alpha, 255u), 1u) : 0u; }

float layerScale(uint exponent) { return asfloat((exponent + 124u) << 23); }

// \param alpha as of layerAlphaOf
uint packLayer(float3 light, uint alpha) {
  // NaN becomes black.
  float largest = max(light.x, max(light.y, light.z));
  largest = largest > kDimmestLayer ? min(largest, kBrightestLayer) : kDimmestLayer;
  // Bits below those of a power of two have the next smaller exponent.
  uint exponent = ((asuint(largest) - 1u) >> 23) - 123u;
  float scale = layerScale(exponent);
  return roundedShare(light.x / scale, 127u) | (roundedShare(light.y / scale, 127u) << 7) |
         (roundedShare(light.z / scale, 127u) << 14) | (exponent << 21) | (alpha << 24);
}

float alphaOfLayer(uint layer) { return squared(layer >> 24, 255u); }

float3 lightOfLayer(uint layer) {
  float3 share =
      float3(float(layer & 127u), float((layer >> 7) & 127u), float((layer >> 14) & 127u)) / 127.0;
  return share * layerScale((layer >> 21) & 7u);
}

#endif
