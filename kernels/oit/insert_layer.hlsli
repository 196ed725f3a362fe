// The cascade of maxima of nearest_depths.hlsli. The including file first defines
//   LAYER_DEPTHS  the StructuredBuffer<uint> of the keys
//   LAYER_COLORS  the RWStructuredBuffer<uint> of the words
#ifndef PELAGE_OIT_INSERT_LAYER_HLSLI
#define PELAGE_OIT_INSERT_LAYER_HLSLI

#include "nearest_depths.hlsli"

// \param depth first slot of the pixel's keys, \param color that of its words
// \param place index of the first key that is not nearer, \param count of slots
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

#endif
