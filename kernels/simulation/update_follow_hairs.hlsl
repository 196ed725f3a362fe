// Poses the follow hairs beside their guides.
//
// Threads: x = 4 follow hairs, y = vertex; dispatch ceil(g_followCount / 4) x g_vertexCount, at
//          most 2,097,120 strands. A thread shares what its strands have in common: everything
//          about the guide if they have the same one.
// Reads:   g_followHairRecords, g_rootTransforms, g_rest (vertex 0), g_positions and g_tangents of
//          the guides
// Writes:  g_positions and g_tangents of the follow hairs; strand g_guideCount + f
//
// simulation/follow_vertex.hlsli has the formula; the root is that at g_rootEnd.
//
// Invariant (tests/simulation): distance and direction from the guides' mean, seen from the root,
// do not change with the root's motion; a strand without a guide is not written.
#include "root_pose.hlsli"
#include "strand_indexing.hlsli"

float4 guidePosition(uint guide, uint vertex) { return g_positions[vertexIndex(guide, vertex)]; }

float3 guideTangent(uint guide, uint vertex) { return g_tangents[vertexIndex(guide, vertex)].xyz; }

float4 guideRotation(uint guide) {
  float3 bindRoot = g_rest[guideIndex(0, 0, guide)].xyz;
  return rootPoseAt(guide, bindRoot, g_rootEnd).rotation;
}

#include "follow_vertex.hlsli"

[numthreads(8, 16, 1)] void update_follow_hairs(uint3 group
                                                : SV_GroupID, uint slot
                                                : SV_GroupIndex) {
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;
  // Neighboring threads have neighboring vertices.
  uint vertex = group.y * 16 + slot % 16;
  uint first = (group.x * 8 + slot / 16) * kStrandsAThread;
  if (vertex >= g_vertexCount || first >= g_followCount) return;

  FollowHairRecord strand = g_followHairRecords[first];
  GuideVertex guides =
      loadGuides(strand.guides, strand.weights, vertex, g_vertexCount, g_guideCount);
  uint4 loaded = strand.guides;
  float4 loadedWeights = strand.weights;
  uint end = min(first + kStrandsAThread, g_followCount);
  for (uint follow = first; follow < end; ++follow) {
    strand = g_followHairRecords[follow];
    bool same =
        all(strand.guides.xyz == loaded.xyz) && all(strand.weights.xyz == loadedWeights.xyz);
    if (!same) {
      guides = loadGuides(strand.guides, strand.weights, vertex, g_vertexCount, g_guideCount);
      loaded = strand.guides;
      loadedWeights = strand.weights;
    }
    if (!guides.known) continue;
    FollowVertex evaluated =
        followVertex(guides, strand.offset, g_tipSeparation, vertex, g_vertexCount);
    uint to = vertexIndex(g_guideCount + follow, vertex);
    g_positions[to] = float4(evaluated.position, guides.position.w);
    g_tangents[to] = float4(evaluated.tangent, 0.0);
  }
}
