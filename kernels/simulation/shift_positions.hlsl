// Moves positions to a new origin of the world: those of the last frame and those of follow hairs
// that collide, which no state stores more precisely.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_shiftedPositions
// Writes:  g_shiftedPositions
//
// Invariant (tests/simulation): a position is the float sum of its old value and g_shift; w, and
// the elements before g_shiftedFirst and behind the last one, keep their bits.
#include "../base/dispatch.hlsli"

cbuffer ShiftPositionsConstants : register(b0, space0) {
  uint g_shiftedFirst;  // element; first: decision 0008
  uint g_shiftedCount;
  uint g_shiftedPad0;
  uint g_shiftedPad1;
  float4 g_shift;  // xyz what to add [m]; w unused
};

// xyz world position [m]; w is kept.
RWStructuredBuffer<float4> g_shiftedPositions : register(u0, space0);

[numthreads(64, 1, 1)]
void shift_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_shiftedCount) return;
  float4 old = g_shiftedPositions[g_shiftedFirst + index];
  precise float3 moved = old.xyz + g_shift.xyz;
  g_shiftedPositions[g_shiftedFirst + index] = float4(moved, old.w);
}
