// Writes the group counts that cover g_count elements with groups of 64.
//
// One thread.
// Writes g_arguments.
// Invariant: an indirect dispatch with them touches every element.
#include "runtime_compute.hlsli"

[numthreads(1, 1, 1)]
void write_arguments(uint3 id : SV_DispatchThreadID) {
  if (id.x != 0u) return;
  g_arguments[0] = (g_count + 63u) / 64u;
  g_arguments[1] = 1u;
  g_arguments[2] = 1u;
}
