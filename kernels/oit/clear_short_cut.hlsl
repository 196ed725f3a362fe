// Empties the layers of all pixels.
//
// Threads: four per pixel; the first ones of a row also clear its tiles and the counters.
// Writes:  g_shortCutDepths, g_shortCutClearedColors, g_shortCutTiles, g_shortCutCounters
#include "layouts/short_cut_depths_alpha.hlsli"
#include "nearest_depths.hlsli"

[numthreads(128, 1, 1)]
void clear_short_cut(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  // Rows of pixels in y: a dispatch has at most 65,535 groups per axis.
  uint x = group.x * 128u + lane;
  uint y = group.y;
  uint width = g_shortCutWidth;
  if (x >= 4u * width || y >= g_shortCutHeight) return;
  g_shortCutDepths[4u * width * y + x] = (x & 3u) == 3u ? 0u : kNoDepth;
  if (x < 3u * width) g_shortCutClearedColors[3u * width * y + x] = 0u;
  if ((y & (kTileEdge - 1u)) == 0u && x < g_shortCutTileColumns)
    g_shortCutTiles[(y >> kTileShift) * g_shortCutTileColumns + x] = 0u;
  if (y == 0u && x == 0u) {
    g_shortCutCounters[0] = 6u;
    for (uint word = 1u; word < kCounterWords; ++word) g_shortCutCounters[word] = 0u;
  }
}
