// Empties the lists of all pixels.
//
// Threads: one per pixel; the first ones also clear tiles and counters.
// Writes:  g_listHeads, g_listTiles, g_listCounters; with TAIL g_listTail
#include "layouts/ppll_build.hlsli"
#include "pixel_tiles.hlsli"
#include "ppll_counters.hlsli"

[numthreads(128, 1, 1)]
void clear_ppll(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  // Rows of pixels in y: a dispatch has at most 65,535 groups per axis.
  uint x = group.x * 128u + lane;
  uint y = group.y;
  if (x >= g_listWidth || y >= g_listHeight) return;
  uint pixel = y * g_listWidth + x;
  g_listHeads[pixel] = 0u;
#if TAIL
  for (uint i = 0u; i < 4u; ++i) g_listTail[4u * pixel + i] = 0u;
#endif
  uint tiles = g_listTileColumns * ((g_listHeight + (kTileEdge - 1u)) / kTileEdge);
  // There are fewer tiles than pixels.
  if (pixel < tiles) g_listTiles[pixel] = 0u;
  if (pixel == 0u) {
    g_listCounters[0] = 6u;
    for (uint word = 1u; word < kCounterWords; ++word) g_listCounters[word] = 0u;
  }
}
