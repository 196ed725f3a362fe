// Fixture: atomics, a byte buffer, and an axis that changes nothing.
#include "particles.hlsli"

[numthreads(32, 2, 1)]
void count_particles(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_particleCount || id.y > 0) return;
  const uint2 cell = g_particles[id.x].cell;
  uint old;
  InterlockedAdd(g_cellCounts[cell.x + 16 * cell.y], 1, old);
  g_log.Store(4 * id.x, old + uint(g_gridOrigin.x) + g_lastOne + uint(g_window.x));
}
