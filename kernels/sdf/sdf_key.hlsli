// What a node of a signed distance field holds: one key of 32 bits.
//
//   bit 31           inside
//   bit 30           far: beyond the band
//   30 - b bits      code of the distance
//   b bits           triangle that is nearest, b = SdfField::triangleBits
//
// A near code counts band / (2^(30-b) - 1), a far code farRange / (2^(30-b) - 1) beyond the band, so
// that a smaller key without its sign is a smaller distance and, of equal ones, a smaller triangle:
// an atomic minimum gives the same key in any order. 16,384 triangles leave 15 bits: with a band of 2
// cells the distance is off by up to 3.1e-5 cell.
// Only coarse nodes have far keys: sdfCoarseStride(). (All inside nodes of files that older versions
// saved have.) Where parts of a mesh overlap, the triangle of a key may be none, all its bits set:
// the distance is that of a surface that is swallowed, and no more than that of the outer one.
#ifndef PELAGE_SDF_SDF_KEY_HLSLI
#define PELAGE_SDF_SDF_KEY_HLSLI

#include "../layouts/sdf_field.hlsli"

// A node that nothing has reached: outside, at least the band away. With kSdfInside: inside, as
// deep.
static const uint kSdfUnset = 0x7fffffffu;
static const uint kSdfInside = 0x80000000u;
static const uint kSdfFar = 0x40000000u;

// Deep inside, only nodes whose coordinates are all multiples of this know their triangle. For every
// point that is deeper than the band the eight such nodes around it include one that does: the
// nearest one is within sqrt(3) / 2 strides, and outside by no more than that without the band.
uint sdfCoarseShift(float band) { return band >= 2.0 ? 2u : 1u; }
uint sdfCoarseStride(float band) { return 1u << sdfCoarseShift(band); }

bool sdfIsInside(uint key) { return (key & kSdfInside) != 0u; }
bool sdfIsSet(uint key) { return (key & kSdfUnset) != kSdfUnset; }
uint sdfTriangle(uint key, uint triangleBits) { return key & ((1u << triangleBits) - 1u); }

float sdfGreatestCode(uint triangleBits) { return float((1u << (30u - triangleBits)) - 1u); }

// \param distance  [cell], 0 to band
uint sdfNearKey(float distance, uint index, float band, uint triangleBits) {
  precise float most = sdfGreatestCode(triangleBits);
  precise float code = min(max(distance / band * most + 0.5, 0.0), most);
  return (uint(code) << triangleBits) | index;
}

// \param distance  [cell], from the surface, at least the band
uint sdfFarKey(float distance, uint index, float band, float farRange, uint triangleBits) {
  precise float most = sdfGreatestCode(triangleBits);
  precise float code = min(max((distance - band) / farRange * most + 0.5, 0.0), most);
  return kSdfFar | (uint(code) << triangleBits) | index;
}

// Distance [cell], negative inside. What is unset is as far as the band reaches: never further away
// than in truth.
float sdfDistance(uint key, float band, float farRange, uint triangleBits) {
  uint magnitude = key & kSdfUnset;
  precise float distance = band;
  if (magnitude != kSdfUnset) {
    precise float code = float((magnitude & (kSdfFar - 1u)) >> triangleBits);
    precise float share = code / sdfGreatestCode(triangleBits);
    distance = (magnitude & kSdfFar) != 0u ? band + share * farRange : share * band;
  }
  return sdfIsInside(key) ? -distance : distance;
}

#endif
