// The nearest depths of a pixel, found by all its fragments at once, and the words that belong to
// them. For the kernels of the methods with a fixed number of layers.
//
// A cascade of atomic minima: a key goes into the first slot that has a farther one, and the one
// that it drove out goes on to the next slot. A slot's final value is the minimum of all that ever
// reached it, and what goes on is the rest, so the slots hold the nearest keys in order, whoever
// came first; equal keys each have a slot. A slot only ever falls, so one that plain loads find
// nearer, however old the value, needs no atomic.
//
// The second draw gives each slot the word of the fragment of that key, by the same cascade with
// maxima over the slots of one key: what drops out of it belongs to no slot, again whoever came
// first.
//
// Both draws run the same vertex kernel, whose position is declared invariant, with the same depth
// state: they see the same bits of depth. A fragment that found others would not be lost, but go
// where those beyond the slots go.
#ifndef PELAGE_OIT_NEAREST_DEPTHS_HLSLI
#define PELAGE_OIT_NEAREST_DEPTHS_HLSLI

#include "fragment_packing.hlsli"

static const uint kNoDepth = 0xffffffffu;
static const uint kNoPixel = 0xffffffffu;

uint layerKey(float depth, bool reversed) {
  return min(depthKey(depth, reversed), kNoDepth - 1u);
}

// Place of a pixel in buffers of the viewport's size, or kNoPixel outside of them. The viewport's
// offset is subtracted (K41).
uint layerPixel(float2 place, float2 origin, uint width, uint height) {
  int2 at = int2(place) - int2(origin);
  if (at.x < 0 || at.y < 0 || uint(at.x) >= width || uint(at.y) >= height) return kNoPixel;
  return uint(at.y) * width + uint(at.x);
}

#endif
