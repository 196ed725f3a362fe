// Moves positions to a new origin of the world, where no state stores them more precisely: those of
// the last frame, and those of follow hairs that collide.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_shiftedPositions
// Writes:  g_shiftedPositions
//
// Invariant (tests/simulation): a position is the float sum of what it was and g_shift; w, and what
// is before g_shiftedFirst or behind the last element, keep their bits.
#include "../base/dispatch.hlsli"
#include "../skinning/layouts/shift_positions.hlsli"

[numthreads(64, 1, 1)]
void shift_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_shiftedCount) return;
  float4 old = g_shiftedPositions[g_shiftedFirst + index];
  precise float3 moved = old.xyz + g_shift.xyz;
  g_shiftedPositions[g_shiftedFirst + index] = float4(moved, old.w);
}
