// The nearest depths of a pixel, found by all its fragments in parallel, and the words that belong
// to them. For the methods with a fixed number of layers.
//
// A cascade of atomic minima: a key goes into the first slot with a farther key, and the displaced
// key goes on to the next slot. A slot's final value is the minimum of all keys that reached it,
// and the rest goes on, so the slots hold the nearest keys in order, whatever the order of arrival;
// equal keys each have a slot. A slot's value only decreases, so if a plain load finds a nearer
// key, however old the value, no atomic is needed.
//
// The second draw stores in each slot the word of the fragment with that key, by the same cascade
// with maxima over the slots of one key: words that drop out belong to no slot, again whatever the
// order of arrival.
//
// Both draws run the same vertex kernel, whose position is declared invariant, with the same depth
// state: they produce the same bits of depth. A fragment with other bits would not be lost; it
// would be treated as one beyond the slots.
#ifndef PELAGE_OIT_NEAREST_DEPTHS_HLSLI
#define PELAGE_OIT_NEAREST_DEPTHS_HLSLI

#include "fragment_packing.hlsli"

static const uint kNoDepth = 0xffffffffu;
static const uint kNoPixel = 0xffffffffu;

uint layerKey(float depth, bool reversed) {
  return min(depthKey(depth, reversed), kNoDepth - 1u);
}

// Returns the index of a pixel in buffers of the viewport's size, or kNoPixel outside of them. The
// viewport's offset is subtracted (K41).
uint layerPixel(float2 pixelPosition, float2 origin, uint width, uint height) {
  int2 at = int2(pixelPosition) - int2(origin);
  if (at.x < 0 || at.y < 0 || uint(at.x) >= width || uint(at.y) >= height) return kNoPixel;
  return uint(at.y) * width + uint(at.x);
}

#endif
