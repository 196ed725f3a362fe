// Empties all pixels.
//
// Threads: one per pixel of a tile.
// Writes:  g_binPixels
#include "../layouts/strand_tiles.hlsli"

[numthreads(128, 1, 1)]
void clear_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint pixel = (group.y * 32768u + group.x) * 128u + lane;
  if (pixel < 64u * g_binTileCount) g_binPixels[pixel] = 0u;
}
