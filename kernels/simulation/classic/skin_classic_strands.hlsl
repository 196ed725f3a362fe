// Poses the guides of the classic solver without simulating them: the bind shape, moved rigidly
// with each root. The state becomes one that simulate_classic continues from, with the velocity of
// the motion since the last frame.
//
// Threads: one per vertex of the guides, strand fastest, in rows of 2^20.
// Reads:   g_rest, g_state (the roots)
// Writes:  g_state (current and previous), g_positions and g_tangents of the guides
//
// The frame counts as one step. As after a step of simulate_classic, the previous position includes
// the motion that velocity shock propagation transports, here with g_vspCoefficient alone.
//
// Invariant (tests/simulation): positions are those of the bind pose, moved by the root, to
// rounding; a simulation that continues without gravity moves vertices on with their velocity.
#define ROOTS_IN_STATE
#include "../../base/dispatch.hlsli"
#include "../root_pose.hlsli"
#include "../strand_indexing.hlsli"

float3 bindPosition(uint vertex, uint guide) { return g_rest[guideIndex(0, vertex, guide)].xyz; }

// Returns the direction from the previous to the next vertex; where they coincide, the last
// direction before them.
float3 bindDirection(uint vertex, uint guide) {
  uint to = min(vertex + 1, g_vertexCount - 1);
  float3 none = float3(0.0, 0.0, 0.0);
  precise float3 across = bindPosition(to, guide) - bindPosition(max(vertex, 1) - 1, guide);
  float3 direction = directionOr(across, none);
  for (uint i = to; i > 0 && !(dot3(direction, direction) > 0.0); --i) {
    precise float3 segment = bindPosition(i, guide) - bindPosition(i - 1, guide);
    direction = directionOr(segment, none);
  }
  return dot3(direction, direction) > 0.0 ? direction : float3(1.0, 0.0, 0.0);
}

[numthreads(64, 1, 1)]
void skin_classic_strands(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices || g_guideCount == 0u) return;
  uint vertex = index / g_guideCount;
  if (vertex >= g_vertexCount) return;
  uint guide = index - vertex * g_guideCount;

  float3 bindRoot = bindPosition(0, guide);
  float4 bind = g_rest[guideIndex(0, vertex, guide)];
  RootPose begin = rootPoseAt(guide, bindRoot, 0.0);
  RootPose end = rootPoseAt(guide, bindRoot, 1.0);
  float3 x = targetPosition(end, bindRoot, bind.xyz);

  // From where the bind shape is now to where it was transported.
  float share = saturate(g_vspCoefficient);
  float4 motion = normalizeQuaternion(multiplyQuaternions(end.rotation, conjugate(begin.rotation)));
  float4 transported = interpolateQuaternions(float4(0.0, 0.0, 0.0, 1.0), motion, share);
  float4 back = normalizeQuaternion(multiplyQuaternions(transported, conjugate(motion)));
  precise float3 shift = (end.position - begin.position) * (1.0 - share);
  precise float3 before = x - (shift - rotationDelta(back, x - end.position));
  // The root's own history has its whole motion.
  if (vertex == 0u) before = begin.position;

  g_state[guideIndex(0, vertex, guide)] = float4(x, 0.0);
  g_state[guideIndex(1, vertex, guide)] = float4(before, 0.0);
  precise float3 world = x + g_origin.xyz;
  bool held = vertex < 2 || !(bind.w > 0.0);
  uint element = vertexIndex(guide, vertex);
  g_positions[element] = float4(world, held ? 0.0 : 1.0);
  g_tangents[element] = float4(rotate(end.rotation, bindDirection(vertex, guide)), 0.0);
}
