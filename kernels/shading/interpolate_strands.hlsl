// Places strands between the last two states of the simulation, for drawing between fixed steps.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_positionsBefore, g_positionsNow
// Writes:  g_drawnPositions, g_drawnTangents
//
// A vertex is on the line between its two positions; edges that rotate by an angle a between the
// states are shorter by cos(a / 2) at most. A tangent is the direction from the previous to the
// next vertex, as the solvers compute it; where these coincide (vertices past the end of a short
// strand) it is that of the nearest edge before.
//
// Invariant (tests/shading/strand_interpolation_test.cpp): a share of 0 and of 1 keep the bits of
// the two states.
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"

cbuffer InterpolateStrandsConstants : register(b0, space0) {
  uint g_interpolatedCount;     // elements
  uint g_interpolatedVertices;  // of a strand, >= 2
  float g_interpolatedShare;    // 0: the state before, 1: the state now
  uint g_interpolatedPad0;
};

// [strand][vertex]: xyz world position [m] in the two states; w inverse mass.
StructuredBuffer<float4> g_positionsBefore : register(t0, space0);
StructuredBuffer<float4> g_positionsNow : register(t1, space0);
// [strand][vertex]: positions and tangents for drawing; the tangents are unit vectors, w = 0.
RWStructuredBuffer<float4> g_drawnPositions : register(u0, space0);
RWStructuredBuffer<float4> g_drawnTangents : register(u1, space0);

float4 positionAt(uint element) {
  float4 before = g_positionsBefore[element];
  float4 now = g_positionsNow[element];
  if (g_interpolatedShare >= 1.0) return now;
  if (g_interpolatedShare <= 0.0) return float4(before.xyz, now.w);
  precise float3 between = before.xyz + (now.xyz - before.xyz) * g_interpolatedShare;
  return float4(between, now.w);
}

[numthreads(64, 1, 1)]
void interpolate_strands(uint3 thread : SV_DispatchThreadID) {
  uint element = indexOfThread(thread);
  if (element >= g_interpolatedCount) return;
  uint vertex = element % g_interpolatedVertices;
  float4 position = positionAt(element);
  float3 before = vertex > 0u ? positionAt(element - 1u).xyz : position.xyz;
  float3 after = position.xyz;
  if (vertex + 1u < g_interpolatedVertices && element + 1u < g_interpolatedCount)
    after = positionAt(element + 1u).xyz;
  float3 none = float3(0.0, 0.0, 0.0);
  float3 tangent = directionOr(after - before, none);
  for (uint back = 1u; back <= vertex && !(dot3(tangent, tangent) > 0.0); ++back) {
    float3 edge = positionAt(element - back + 1u).xyz - positionAt(element - back).xyz;
    tangent = directionOr(edge, none);
  }
  g_drawnPositions[element] = position;
  g_drawnTangents[element] = float4(tangent, 0.0);
}
