// Places the follow strands beside their guides.
//
// Threads: x = 4 follow strands, y = vertex; dispatch ceil(g_followCount / 4) x g_vertexCount, at
//          most 2,097,120 strands. A thread keeps what its strands have in common: all of the guide
//          when they are neighbours.
// Reads:   g_followStrands, g_rootTransforms, g_rest (vertex 0), g_positions and g_tangents of the
//          guides
// Writes:  g_positions and g_tangents of the follow strands; strand g_guideCount + f
//
// common/follow_vertex.hlsli says where they are; the root is that at g_rootEnd.
//
// Invariant (tests/kernel): distance and direction from the guides' mean, seen from the root, do
// not change with the root's motion; a strand without a guide is not written.
#include "../common/root_pose.hlsli"
#include "../common/strand_indexing.hlsli"

static const uint kStrandsAThread = 4;

float4 guidePosition(uint guide, uint vertex) { return g_positions[vertexIndex(guide, vertex)]; }

float3 guideTangent(uint guide, uint vertex) { return g_tangents[vertexIndex(guide, vertex)].xyz; }

float4 guideRotation(uint guide) {
  float3 bindRoot = g_rest[guideIndex(0, 0, guide)].xyz;
  return rootPoseAt(guide, bindRoot, g_rootEnd).rotation;
}

#include "../common/follow_vertex.hlsli"

[numthreads(8, 16, 1)] void update_follow_strands(uint3 group
                                                  : SV_GroupID, uint place
                                                  : SV_GroupIndex) {
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;
  // Neighbouring threads have neighbouring vertices.
  uint vertex = group.y * 16 + place % 16;
  uint first = (group.x * 8 + place / 16) * kStrandsAThread;
  if (vertex >= g_vertexCount || first >= g_followCount) return;

  FollowStrand strand = g_followStrands[first];
  GuideVertex guides =
      loadGuides(strand.guides, strand.weights, vertex, g_vertexCount, g_guideCount);
  uint4 loaded = strand.guides;
  float4 loadedWeights = strand.weights;
  uint end = min(first + kStrandsAThread, g_followCount);
  for (uint follow = first; follow < end; ++follow) {
    strand = g_followStrands[follow];
    bool same =
        all(strand.guides.xyz == loaded.xyz) && all(strand.weights.xyz == loadedWeights.xyz);
    if (!same) {
      guides = loadGuides(strand.guides, strand.weights, vertex, g_vertexCount, g_guideCount);
      loaded = strand.guides;
      loadedWeights = strand.weights;
    }
    if (!guides.known) continue;
    FollowVertex placed =
        followVertex(guides, strand.offset, g_tipSeparation, vertex, g_vertexCount);
    uint to = vertexIndex(g_guideCount + follow, vertex);
    g_positions[to] = float4(placed.position, guides.position.w);
    g_tangents[to] = float4(placed.tangent, 0.0);
  }
}
