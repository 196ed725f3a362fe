// Places root frames between the last two states of the simulation, for follow hairs that drawing
// computes from their guides.
//
// Threads: one a guide, in rows of 2^20.
// Reads:   g_stateRoots
// Writes:  g_drawnRoots: what was drawn before is kept in set 1
//
// Invariant (tests/shading/strand_interpolation_test.cpp): a share of 0 and of 1 keep the bits of the
// two states; rotations are unit quaternions.
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"
#include "layouts/interpolate_roots.hlsli"

[numthreads(64, 1, 1)]
void interpolate_roots(uint3 thread : SV_DispatchThreadID) {
  uint guide = indexOfThread(thread);
  if (guide >= g_interpolatedRoots) return;
  RootTransform now = g_stateRoots[guide];
  RootTransform before = g_stateRoots[g_interpolatedRoots + guide];
  RootTransform last = g_drawnRoots[guide];
  RootTransform drawn = now;
  // Sets that were never written, or cannot be a pose, are left to who reads them.
  bool poses = isPose(now.rotation, now.position.xyz) && isPose(before.rotation, before.position.xyz);
  if (poses && g_interpolatedRootShare < 1.0) {
    float share = max(g_interpolatedRootShare, 0.0);
    drawn.rotation = interpolateQuaternions(before.rotation, now.rotation, share);
    precise float3 between =
        before.position.xyz + (now.position.xyz - before.position.xyz) * share;
    drawn.position = float4(share > 0.0 ? between : before.position.xyz, now.position.w);
  }
  if (g_rootsRestart != 0u) last = drawn;
  g_drawnRoots[guide] = drawn;
  g_drawnRoots[g_interpolatedRoots + guide] = last;
}
