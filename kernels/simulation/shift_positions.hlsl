// Moves positions to a new origin of the world, where no state has them in a finer form: the last
// frame's, and those of follow strands that collide.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_shiftedPositions
// Writes:  g_shiftedPositions
//
// Invariant (tests/kernel): a position is the float sum of what it was and g_shift; w, and what is
// before g_shiftedFirst or behind the last element, keep their bits.
#include "../layouts/shift_positions.hlsli"

[numthreads(64, 1, 1)]
void shift_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = (thread.y << 20) | thread.x;
  if (index >= g_shiftedCount) return;
  float4 old = g_shiftedPositions[g_shiftedFirst + index];
  precise float3 moved = old.xyz + g_shift.xyz;
  g_shiftedPositions[g_shiftedFirst + index] = float4(moved, old.w);
}
