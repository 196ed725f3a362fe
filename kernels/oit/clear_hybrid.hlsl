// Empties the layers of all pixels.
//
// Threads: one per layer; the first ones of a row also clear its tail, tiles and counters.
// Writes:  g_hybridDepths, g_hybridClearedColors, g_hybridClearedTail, g_hybridTiles,
//          g_hybridCounters
#include "layouts/hybrid_depths.hlsli"
#include "nearest_depths.hlsli"

[numthreads(128, 1, 1)]
void clear_hybrid(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  // Rows of pixels in y: a dispatch has at most 65,535 groups per axis.
  uint x = group.x * 128u + lane;
  uint y = group.y;
  uint row = g_hybridWidth * g_hybridLayers;
  if (x >= row || y >= g_hybridHeight) return;
  g_hybridDepths[y * row + x] = kNoDepth;
  g_hybridClearedColors[y * row + x] = 0u;
  // A pixel has at least as many layers as a tail has words.
  if (x < 4u * g_hybridWidth) g_hybridClearedTail[4u * g_hybridWidth * y + x] = 0u;
  if ((y & (kTileEdge - 1u)) == 0u && x < g_hybridTileColumns)
    g_hybridTiles[(y >> kTileShift) * g_hybridTileColumns + x] = 0u;
  if (y == 0u && x == 0u) {
    g_hybridCounters[0] = 6u;
    for (uint word = 1u; word < kCounterWords; ++word) g_hybridCounters[word] = 0u;
  }
}
