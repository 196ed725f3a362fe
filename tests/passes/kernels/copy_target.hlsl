// arguments = target: reads a buffer that the layout declares for writing.
//
// One thread an element; groups of 64.
// Reads g_target; writes g_arguments.
// Invariant: two of them that share g_target need no barrier between them.
#include "runtime_compute.hlsli"

[numthreads(64, 1, 1)]
void copy_target(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_count) return;
  g_arguments[id.x] = g_target[id.x];
}
