// Places root frames between the last two states of the simulation, for follow hairs that drawing
// computes from their guides.
//
// Threads: one a guide, in rows of 2^20.
// Reads:   g_stateRoots
// Writes:  g_drawnRoots; set 1 keeps the poses that were drawn last
//
// Invariant (tests/shading/strand_interpolation_test.cpp): a share of 0 and of 1 keep the bits of
// the two states; rotations are unit quaternions.
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"
#include "../simulation/layouts/follow.hlsli"

cbuffer InterpolateRootsConstants : register(b0, space0) {
  uint g_interpolatedRoots;       // guides
  float g_interpolatedRootShare;  // 0: the state before, 1: the state now
  uint g_rootsRestart;            // 1: the last drawn poses are those drawn now
  uint g_rootsPad0;
};

// [2][guide]: root frames of the last state (0) and the one before (1).
StructuredBuffer<RootTransform> g_stateRoots : register(t0, space0);
// [2][guide]: root frames that are drawn now (0), and those that were drawn last (1).
RWStructuredBuffer<RootTransform> g_drawnRoots : register(u0, space0);

[numthreads(64, 1, 1)]
void interpolate_roots(uint3 thread : SV_DispatchThreadID) {
  uint guide = indexOfThread(thread);
  if (guide >= g_interpolatedRoots) return;
  RootTransform now = g_stateRoots[guide];
  RootTransform before = g_stateRoots[g_interpolatedRoots + guide];
  RootTransform last = g_drawnRoots[guide];
  RootTransform drawn = now;
  // A root that was never written, or is no pose, is copied; its readers test it.
  bool poses =
      isPose(now.rotation, now.position.xyz) && isPose(before.rotation, before.position.xyz);
  if (poses && g_interpolatedRootShare < 1.0) {
    float share = max(g_interpolatedRootShare, 0.0);
    drawn.rotation = interpolateQuaternions(before.rotation, now.rotation, share);
    precise float3 between = before.position.xyz + (now.position.xyz - before.position.xyz) * share;
    drawn.position = float4(share > 0.0 ? between : before.position.xyz, now.position.w);
  }
  if (g_rootsRestart != 0u) last = drawn;
  g_drawnRoots[guide] = drawn;
  g_drawnRoots[g_interpolatedRoots + guide] = last;
}
