// The contents of a node of an SDF: one key of 32 bits.
//
//   bit 31           inside
//   bit 30           far: beyond the band
//   30 - b bits      code of the distance
//   b bits           triangle that is nearest, b = Sdf::triangleBits
//
// A near code counts band / (2^(30-b) - 1), a far code farRange / (2^(30-b) - 1) beyond the band.
// So a smaller key without its sign is a smaller distance and, at equal distance, a smaller
// triangle index: an atomic minimum gives the same key in any order. 16,384 triangles leave 15
// bits: with a band of 2 cells the distance is off by up to 3.1e-5 cell. Only coarse nodes have far
// keys: sdfCoarseStride(). (In files of older versions all inside nodes have them.) Where parts of
// a mesh overlap, a key may have no triangle, all its bits set: the distance is then that of a
// surface inside another part, and at most that of the outer surface.
#ifndef PELAGE_SDF_SDF_KEY_HLSLI
#define PELAGE_SDF_SDF_KEY_HLSLI

#include "layouts/sdf.hlsli"

// A node without a triangle: outside, at least the band away. With kSdfInside: inside, as deep.
static const uint kSdfUnset = 0x7fffffffu;
static const uint kSdfInside = 0x80000000u;
static const uint kSdfFar = 0x40000000u;

// Deep inside, only nodes whose coordinates are all multiples of this know their triangle. For
// every point that is deeper than the band the eight such nodes around it include one that does:
// the nearest one is within sqrt(3) / 2 strides, and outside by no more than that without the band.
static const float kSdfWideBand = 2.0;
static const uint kSdfWideShift = 2u;
static const uint kSdfNarrowShift = 1u;
uint sdfCoarseShift(float band) { return band >= kSdfWideBand ? kSdfWideShift : kSdfNarrowShift; }
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

// Returns the distance [cell], negative inside. An unset key counts as the band's width, which is
// never more than the true distance.
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
