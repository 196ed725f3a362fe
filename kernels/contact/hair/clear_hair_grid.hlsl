// Sets the words of the grid's nodes to 0.
//
// Threads: one per word, at most 2^20.
// Writes:  g_gridNodes
//
// Invariant (tests/contact): every word of the g_gridSize^3 nodes is 0, and none after them
// changes.
#include "hair_grid.hlsli"

[numthreads(128, 1, 1)]
void clear_hair_grid(uint3 thread : SV_DispatchThreadID) {
  if (g_gridSize > kMaxGridSize) return;
  uint words = (g_gridSize * g_gridSize * g_gridSize) << channelShift();
  if (thread.x < words) g_gridNodes[thread.x] = 0u;
}
