// The cascade of minima of nearest_depths.hlsli. The including file first defines
//   LAYER_DEPTHS  the RWStructuredBuffer<uint> of the slots
#ifndef PELAGE_OIT_INSERT_DEPTH_HLSLI
#define PELAGE_OIT_INSERT_DEPTH_HLSLI

#include "nearest_depths.hlsli"

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
