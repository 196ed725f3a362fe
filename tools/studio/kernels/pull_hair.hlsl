// Pulls hair towards where the mouse drags it: a spring from each vertex of a lock to its position
// when it was taken, moved by the drag.
//
// Threads: one a vertex of a guide, in rows of 2^20.
// Reads:   g_pullPositions, g_pullTaken
// Writes:  g_pullForces, which the solver reads behind it: HairObject::setForces()
//
// Invariant: vertices without a weight, and those whose position is not finite, get no force; no
// force is larger than the limit (viewer_test).
#include "base/dispatch.hlsli"

cbuffer PullConstants : register(b0, space0) {
  uint g_pullVertexCount;
  float g_pullStiffness;  // [1/s2]
  float g_pullDamping;    // [1/s]
  float g_pullLimit;      // largest acceleration [m/s2]
  float4 g_pullDrag;      // xyz: how far the mouse has dragged [m]; w unused
};

// [guide][vertex]: world position [m]; w unused.
StructuredBuffer<float4> g_pullPositions : register(t0, space0);
// [guide][vertex]: xyz position when the hair was taken [m]; w: weight, 0..1.
StructuredBuffer<float4> g_pullTaken : register(t1, space0);
// [guide][vertex]: xyz acceleration [m/s2], w drag [1/s].
RWStructuredBuffer<float4> g_pullForces : register(u0, space0);

[numthreads(64, 1, 1)]
void pull_hair(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_pullVertexCount) return;
  float4 taken = g_pullTaken[index];
  float3 away = taken.xyz + g_pullDrag.xyz - g_pullPositions[index].xyz;
  float3 force = g_pullStiffness * away;
  float size = length(force);
  float4 result = float4(0.0, 0.0, 0.0, 0.0);
  // False for NaN, too.
  if (taken.w > 0.0 && size < 1e18) {
    force *= min(1.0, g_pullLimit / max(size, 1e-6));
    result = taken.w * float4(force, g_pullDamping);
  }
  g_pullForces[index] = result;
}
