// Writes the arguments of an indirect draw, g_bias words into the buffer: g_factor vertices of
// g_count instances.
//
// One thread.
// Writes g_arguments.
// Invariant: an indirect draw with them draws exactly these.
#include "runtime_compute.hlsli"

[numthreads(1, 1, 1)]
void write_draw_arguments(uint3 id : SV_DispatchThreadID) {
  if (id.x != 0u) return;
  g_arguments[g_bias] = g_factor;
  g_arguments[g_bias + 1u] = g_count;
  g_arguments[g_bias + 2u] = 0u;
  g_arguments[g_bias + 3u] = 0u;
}
