// Pulls hair towards where the mouse drags it: a spring from each vertex of a lock to where it was when
// it was taken, moved by the drag.
//
// Threads: one a vertex of a guide, in rows of 2^20.
// Reads:   g_pullPositions, g_pullTaken
// Writes:  g_pullForces, which the solver reads behind it: HairObject::setForces()
//
// Invariant: vertices without a weight, and those whose position is not finite, get no force; no
// force is larger than the limit (viewer_test).
#include "pull.hlsli"
#include "base/dispatch.hlsli"

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
