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
//
// The including file first defines, for the first draw,
//   LAYER_DEPTHS   the RWStructuredBuffer<uint> of the slots
//   TILE_FLAGS     the RWStructuredBuffer<uint> of the tiles, flags and list
//   TILE_COUNTERS  that of the counters, see ppll_counters.hlsli
// and for the second draw
//   LAYER_DEPTHS   the StructuredBuffer<uint> of the keys
//   LAYER_COLORS   the RWStructuredBuffer<uint> of the words
#ifndef PELAGE_OIT_NEAREST_DEPTHS_HLSLI
#define PELAGE_OIT_NEAREST_DEPTHS_HLSLI

#include "fragment_packing.hlsli"
#include "pixel_tiles.hlsli"
#include "ppll_counters.hlsli"

static const uint kNoDepth = 0xffffffffu;
static const uint kNoPixel = 0xffffffffu;

#ifdef TILE_FLAGS
// Adds the tile of a pixel to the list of tiles with hair.
void markTile(uint2 at, uint columns, uint height) {
  uint tile = (at.y >> kTileShift) * columns + (at.x >> kTileShift);
  if (TILE_FLAGS[tile] != 0u) return;
  uint before;
  InterlockedExchange(TILE_FLAGS[tile], 1u, before);
  if (before != 0u) return;
  uint index;
  InterlockedAdd(TILE_COUNTERS[kCounterTiles], 1u, index);
  TILE_FLAGS[columns * ((height + (kTileEdge - 1u)) >> kTileShift) + index] = tile;
}
#endif

uint layerKey(float depth, bool reversed) { return min(depthKey(depth, reversed), kNoDepth - 1u); }

// Returns the index of a pixel in buffers of the viewport's size, or kNoPixel outside of them. The
// viewport's offset is subtracted (K41).
uint layerPixel(float2 pixelPosition, float2 origin, uint width, uint height) {
  int2 at = int2(pixelPosition) - int2(origin);
  if (at.x < 0 || at.y < 0 || uint(at.x) >= width || uint(at.y) >= height) return kNoPixel;
  return uint(at.y) * width + uint(at.x);
}

#ifdef LAYER_COLORS
// The cascade of maxima.
// \param depth first slot of the pixel's keys, \param color that of its words
// \param index of the first key that is not nearer, \param count of slots
// \return the word for which there is no slot, or 0
uint insertLayer(uint depth, uint color, uint index, uint count, uint key, uint layer) {
  uint moved = layer;
  for (uint i = index; i < count && moved != 0u; ++i) {
    if (LAYER_DEPTHS[depth + i] != key) break;
    uint held;
    InterlockedMax(LAYER_COLORS[color + i], moved, held);
    moved = min(moved, held);
  }
  return moved;
}
#elif defined(LAYER_DEPTHS)
// The cascade of minima.
// \param first slot of the pixel, \param count of its slots
void insertDepth(uint first, uint count, uint key) {
  uint moved = key;
  for (uint i = 0u; i < count && moved != kNoDepth; ++i) {
    uint held = LAYER_DEPTHS[first + i];
    if (held > moved) {
      InterlockedMin(LAYER_DEPTHS[first + i], moved, held);
      moved = max(moved, held);
    }
  }
}
#endif

#endif
