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

cbuffer KeepPositionsConstants : register(b0, space0) {
  uint g_keptCount;      // elements
  uint g_keptMovedFrom;  // elements from here on are moved by g_keptMove
  uint g_keptPad0;
  uint g_keptPad1;
  float4 g_keptMove;  // xyz [m]; w unused
};

// [strand][vertex]: xyz world position [m]; w inverse mass.
StructuredBuffer<float4> g_positionsToKeep : register(t0, space0);
RWStructuredBuffer<float4> g_keptPositions : register(u0, space0);

[numthreads(64, 1, 1)]
void keep_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_keptCount) return;
  float4 position = g_positionsToKeep[index];
  precise float3 moved = position.xyz + g_keptMove.xyz;
  if (index >= g_keptMovedFrom) position = float4(moved, position.w);
  g_keptPositions[index] = position;
}
