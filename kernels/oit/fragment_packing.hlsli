// A fragment of hair in three words and six bits: depth, tangent with alpha, color; material.
//
// All values are rounded to nearest. Alpha and color are stored as square roots, so that thin
// coverage and dark hair keep as many digits as bright hair:
//   shape = tangent x 11 bits | tangent y 11 | sqrt(alpha) 10
//   color = sqrt(r) 11 bits | sqrt(g) 11 | sqrt(b) 10
// A list's node is {link, depth key, shape, color} with
//   link  = index of the next node + 1, or 0 at the end: 26 bits | material 6
//
// Invariant (tests/oit): a round trip of any input gives finite values in range; no value
// overflows into another's bits.
#ifndef PELAGE_OIT_FRAGMENT_PACKING_HLSLI
#define PELAGE_OIT_FRAGMENT_PACKING_HLSLI

#include "../base/octahedral.hlsli"

static const uint kNodeWords = 4u;  // of a list
static const uint kMaterialLimit = 64u;
static const uint kMaxNodes = 0x3ffffffu;

// \return 0..maximum; NaN gives 0.
uint roundedShare(float share, uint maximum) {
  float scaled = share > 0.0 ? min(share, 1.0) * float(maximum) + 0.5 : 0.0;
  return min(uint(scaled), maximum);
}

uint roundedRoot(float value, uint maximum) {
  return roundedShare(value > 0.0 ? sqrt(min(value, 1.0)) : 0.0, maximum);
}

float squared(uint root, uint maximum) {
  float share = float(root) / float(maximum);
  return share * share;
}

// Nearer is smaller, for standard and for reversed depth.
uint depthKey(float depth, bool reversed) {
  // Negative depths and NaN, which no rasterizer gives, count as 0.
  uint bits = asuint(depth > 0.0 ? min(depth, 1.0) : 0.0);
  return reversed ? ~bits : bits;
}

float depthOfKey(uint key, bool reversed) { return asfloat(reversed ? ~key : key); }

// \param tangent of any length
uint packShape(float3 tangent, float alpha) {
  float2 flat = octahedralOf(tangent);
  return roundedShare(flat.x * 0.5 + 0.5, 2046u) | (roundedShare(flat.y * 0.5 + 0.5, 2046u) << 11) |
         (roundedRoot(alpha, 1023u) << 22);
}

float alphaOfShape(uint shape) { return squared(shape >> 22, 1023u); }

float3 tangentOfShape(uint shape) {
  return directionOfOctahedral(float2(float(shape & 2047u), float((shape >> 11) & 2047u)) / 1023.0 -
                               1.0);
}

// \param color linear, beyond 0..1 clamped
uint packColor(float3 color) {
  return roundedRoot(color.x, 2047u) | (roundedRoot(color.y, 2047u) << 11) |
         (roundedRoot(color.z, 1023u) << 22);
}

float3 colorOf(uint color) {
  return float3(squared(color & 2047u, 2047u), squared((color >> 11) & 2047u, 2047u),
                squared(color >> 22, 1023u));
}

// \param next index of a node + 1, at most kMaxNodes, or 0
uint packLink(uint next, uint material) {
  return next | (min(material, kMaterialLimit - 1u) << 26);
}
uint nextOf(uint link) { return link & 0x3ffffffu; }
uint materialOf(uint link) { return link >> 26; }

#endif
