// Places the follow strands beside their guides.
//
// Threads: x = follow strand, y = vertex; dispatch g_followCount x g_vertexCount, at most 1,048,560
//          strands. 16 x 4 a group: neighbours in a wave fill whole 32-byte sectors.
// Reads:   g_followStrands, g_rootTransforms, g_rest (vertex 0), g_positions and g_tangents of the
//          guides
// Writes:  g_positions and g_tangents of the follow strands; strand g_guideCount + f
//
// A vertex is that of the guide plus the offset, turned by the root's rotation relative to the bind
// pose at g_rootEnd, so that follow hairs keep their place on a scalp that turns. The offset's
// length goes linearly from 1 at the root to separation at the tip:
//   s(v) = 1 + (offset.w * tipSeparation - 1) v / (V - 1)
// The tangent is the direction from the vertex before to the one after, as for guides.
//
// Invariant (tests/kernel): distance and direction from the guide, seen from the root, do not
// change with the root's motion; a strand whose guide does not exist is not written.
#include "../common/root_pose.hlsli"
#include "../common/strand_indexing.hlsli"

float3 followPosition(uint guide, uint vertex, float3 offset, float separation) {
  precise float along = float(vertex) / float(g_vertexCount - 1);
  precise float factor = 1.0 + (separation - 1.0) * along;
  precise float3 p = g_positions[vertexIndex(guide, vertex)].xyz + offset * factor;
  return p;
}

[numthreads(16, 4, 1)]
void update_follow_strands(uint3 thread : SV_DispatchThreadID) {
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;
  uint follow = thread.x;
  uint vertex = thread.y;
  if (follow >= g_followCount || vertex >= g_vertexCount) return;

  FollowStrand strand = g_followStrands[follow];
  if (strand.guide >= g_guideCount) return;

  float3 bindRoot = g_rest[guideIndex(0, 0, strand.guide)].xyz;
  RootPose pose = rootPoseAt(strand.guide, bindRoot, g_rootEnd);
  float3 offset = rotate(pose.rotation, strand.offset.xyz);
  precise float separation = strand.offset.w * g_tipSeparation;

  float3 p = followPosition(strand.guide, vertex, offset, separation);
  float3 before = p;
  float3 after = p;
  if (vertex > 0) before = followPosition(strand.guide, vertex - 1, offset, separation);
  if (vertex + 1 < g_vertexCount)
    after = followPosition(strand.guide, vertex + 1, offset, separation);
  precise float3 across = after - before;

  uint fromGuide = vertexIndex(strand.guide, vertex);
  uint to = vertexIndex(g_guideCount + follow, vertex);
  float3 tangent = directionOr(across, g_tangents[fromGuide].xyz);
  g_positions[to] = float4(p, g_positions[fromGuide].w);
  g_tangents[to] = float4(tangent, 0.0);
}
