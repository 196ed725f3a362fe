// target = source times a specialization constant, plus g_bias where a second one is true.
//
// One thread an element; groups of 64.
// Reads g_source; writes g_target.
// Invariant: without values the defaults hold (factor 2, no bias).
#include "runtime_compute.hlsli"

[[vk::constant_id(0)]] const uint kFactor = 2;
[[vk::constant_id(1)]] const bool kAddBias = false;

[numthreads(64, 1, 1)]
void multiply_by_spec(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_count) return;
  uint value = kFactor * g_source[id.x];
  if (kAddBias) value += g_bias;
  g_target[id.x] = value;
}
