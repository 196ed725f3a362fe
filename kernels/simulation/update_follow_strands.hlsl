// Places the follow strands beside their guides.
//
// Threads: x = 4 follow strands, y = vertex; dispatch ceil(g_followCount / 4) x g_vertexCount, at
//          most 2,097,120 strands. A thread keeps what its strands have in common: all of the guide
//          when they are neighbours.
// Reads:   g_followStrands, g_rootTransforms, g_rest (vertex 0), g_positions and g_tangents of the
//          guides
// Writes:  g_positions and g_tangents of the follow strands; strand g_guideCount + f
//
// A vertex is the weighted mean of its guides' plus the offset, turned by the first guide's root
// relative to the bind pose at g_rootEnd. The offset starts at the mean of the guides' roots, so
// that follow hairs keep their place on a scalp that moves and turns. Its length goes linearly from
// 1 at the root to separation at the tip:
//   s(v) = 1 + (offset.w * tipSeparation - 1) v / (V - 1)
// The tangent is the direction from the vertex before to the one after, as for guides.
//
// Invariant (tests/kernel): distance and direction from the guides' mean, seen from the root, do
// not change with the root's motion; a strand without a guide is not written.
#include "../common/root_pose.hlsli"
#include "../common/strand_indexing.hlsli"

static const uint kStrandsAThread = 4;

// What the guides of a strand say about one vertex.
struct GuideVertex {
  float4 rotation;  // of the first guide's root
  float4 position;  // w: inverse mass of the first guide
  float3 before;    // at the vertex before, or this one
  float3 after;     // at the vertex after, or this one
  float3 tangent;   // of the first guide
  bool known;
};

float weightOf(uint guide, float weight) {
  return guide < g_guideCount && weight > 0.0 && weight < 1e18 ? weight : 0.0;
}

float3 weighted(float3 sum, uint guide, uint vertex, float weight) {
  precise float3 r = sum;
  if (weight > 0.0) r = sum + g_positions[vertexIndex(guide, vertex)].xyz * weight;
  return r;
}

// The mean of three guides, of which one at least counts.
float3 meanPosition(uint4 guides, float3 weights, uint vertex) {
  float3 sum = weighted(float3(0.0, 0.0, 0.0), guides.x, vertex, weights.x);
  sum = weighted(sum, guides.y, vertex, weights.y);
  return weighted(sum, guides.z, vertex, weights.z);
}

GuideVertex loadGuides(uint4 guides, float4 given, uint vertex) {
  GuideVertex g;
  g.rotation = float4(0.0, 0.0, 0.0, 1.0);
  g.position = float4(0.0, 0.0, 0.0, 0.0);
  g.before = float3(0.0, 0.0, 0.0);
  g.after = float3(0.0, 0.0, 0.0);
  g.tangent = float3(0.0, 0.0, 0.0);
  uint before = max(vertex, 1) - 1;
  uint after = min(vertex + 1, g_vertexCount - 1);
  float3 weights =
      float3(weightOf(guides.x, given.x), weightOf(guides.y, given.y), weightOf(guides.z, given.z));
  precise float sum = weights.x + weights.y + weights.z;
  g.known = sum > 0.0;
  if (!g.known) return g;
  uint first = guides.x;
  if (!(weights.x > 0.0)) first = weights.y > 0.0 ? guides.y : guides.z;
  g.position = g_positions[vertexIndex(first, vertex)];
  g.before = g_positions[vertexIndex(first, before)].xyz;
  g.after = g_positions[vertexIndex(first, after)].xyz;
  // One guide is taken as it is; the bits of a mean of one could differ.
  if (sum > max(weights.x, max(weights.y, weights.z))) {
    precise float3 shares = weights / sum;
    g.position = float4(meanPosition(guides, shares, vertex), g.position.w);
    g.before = meanPosition(guides, shares, before);
    g.after = meanPosition(guides, shares, after);
  }
  g.tangent = g_tangents[vertexIndex(first, vertex)].xyz;
  float3 bindRoot = g_rest[guideIndex(0, 0, first)].xyz;
  g.rotation = rootPoseAt(first, bindRoot, g_rootEnd).rotation;
  return g;
}

// Share of the offset's change from root to tip at a vertex.
float alongAt(uint vertex) {
  precise float r = float(vertex) / float(g_vertexCount - 1);
  return r;
}

float3 shifted(float3 p, float along, float3 offset, float separation) {
  precise float factor = 1.0 + (separation - 1.0) * along;
  precise float3 r = p + offset * factor;
  return r;
}

[numthreads(8, 16, 1)] void update_follow_strands(uint3 group
                                                  : SV_GroupID, uint place
                                                  : SV_GroupIndex) {
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;
  // Neighbouring threads have neighbouring vertices.
  uint vertex = group.y * 16 + place % 16;
  uint first = (group.x * 8 + place / 16) * kStrandsAThread;
  if (vertex >= g_vertexCount || first >= g_followCount) return;

  float along = alongAt(vertex);
  float alongBefore = alongAt(max(vertex, 1) - 1);
  float alongAfter = alongAt(min(vertex + 1, g_vertexCount - 1));
  FollowStrand strand = g_followStrands[first];
  GuideVertex guides = loadGuides(strand.guides, strand.weights, vertex);
  uint4 loaded = strand.guides;
  float4 loadedWeights = strand.weights;
  uint end = min(first + kStrandsAThread, g_followCount);
  for (uint follow = first; follow < end; ++follow) {
    strand = g_followStrands[follow];
    bool same =
        all(strand.guides.xyz == loaded.xyz) && all(strand.weights.xyz == loadedWeights.xyz);
    if (!same) {
      guides = loadGuides(strand.guides, strand.weights, vertex);
      loaded = strand.guides;
      loadedWeights = strand.weights;
    }
    if (!guides.known) continue;
    float3 offset = rotate(guides.rotation, strand.offset.xyz);
    precise float separation = strand.offset.w * g_tipSeparation;
    float3 p = shifted(guides.position.xyz, along, offset, separation);
    precise float3 across = shifted(guides.after, alongAfter, offset, separation) -
                            shifted(guides.before, alongBefore, offset, separation);
    uint to = vertexIndex(g_guideCount + follow, vertex);
    g_positions[to] = float4(p, guides.position.w);
    g_tangents[to] = float4(directionOr(across, guides.tangent), 0.0);
  }
}
