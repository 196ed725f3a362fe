// target = 3 target + factor source + bias, modulo 2^32; with DOUBLED the source counts twice.
// Not commutative, so that two passes in the wrong order give other numbers.
//
// One thread an element; groups of 64.
// Reads g_source, g_target; writes g_target.
// Invariant: chained passes give the numbers of the same loop on the host.
#include "runtime_compute.hlsli"

[numthreads(64, 1, 1)]
void accumulate(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_count) return;
  uint source = g_source[id.x];
#if DOUBLED
  source = 2u * source;
#endif
  g_target[id.x] = 3u * g_target[id.x] + g_factor * source + g_bias;
}
