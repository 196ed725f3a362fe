// Writes one number. It has no use for the layout's constants, so that nobody binds them.
//
// One thread.
// Writes g_arguments.
// Invariant: g_arguments[0] is 42 and nothing else changes.
#include "runtime_compute.hlsli"

[numthreads(1, 1, 1)]
void mark(uint3 id : SV_DispatchThreadID) {
  if (id.x != 0u) return;
  g_arguments[0] = 42u;
}
