// Keeps the positions of strands for the motion vectors of the next frame.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_positionsToKeep
// Writes:  g_keptPositions
//
// After a shift of the world's origin, stored follow hairs are still in the old coordinates:
// elements from g_keptMovedFrom on are moved by g_keptMove.
//
// Invariant (tests/shading): all other elements keep their bits.
#include "../../base/dispatch.hlsli"
#include "../layouts/keep_positions.hlsli"

[numthreads(64, 1, 1)]
void keep_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_keptCount) return;
  float4 position = g_positionsToKeep[index];
  precise float3 moved = position.xyz + g_keptMove.xyz;
  if (index >= g_keptMovedFrom) position = float4(moved, position.w);
  g_keptPositions[index] = position;
}
