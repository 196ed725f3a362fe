// Finds the contacts of stored follow hairs with capsules and SDFs before collide_follow_hairs
// walks along them.
//
// Threads: a group of 32 x 4 has 16 vertices of 32 strands: group.x is a tile of 32 strands (or an
//          entry of the list of tiles), group.y a row of 16 vertices. The indirect dispatch of
//          update_follow_hairs has the same groups.
// Reads:   g_followPositions, g_followBefore, g_followContacts (again), g_followWords,
//          g_followColliders, g_followSdfs, g_followKeys, g_followSurface
// Writes:  g_followContacts, g_followWords, g_followBefore but for the first vertex of a strand
//
// A vertex is swept from its position at the end of the last frame to its posed position, and gets
// a contact with each of the (at most two, deepest) colliders within kFollowRange of the latter. In
// a second search, for marked strands, the vertices that the walk has moved are swept from their
// posed position, pushed out, to where the walk has put them. A vertex without a collider nearby
// then keeps its first contacts.
//
// A group first tests which of its vertices may be near a collider, which costs one key or one
// capsule each, and then distributes the queries over its threads.
//
// Invariant (tests/contact): a vertex without a contact is farther than kFollowRange from every
// collider; positions do not change.
#include "layouts/follow_collision.hlsli"
#if SDF
#define SDF_KEYS g_followKeys
#define SDF_SURFACE g_followSurface
#endif
#define CONTACT_CAPSULE(c) g_followColliders[c]
#define CONTACT_CAPSULE_COUNT g_followColliderCount
#define CONTACT_SDF(f) g_followSdfs[f]
#define CONTACT_SDF_COUNT g_followSdfCount
#define CONTACT_SDF_MOTION(f, sdf, p) float3(0.0, 0.0, 0.0)
// A vertex is at its posed position, not at a predicted one; and in every frame it is posed anew on
// the far side of the surface that it rests on.
#define CONTACT_LOOKS 1
#define CONTACT_RESTS true
#include "deepest_contacts.hlsli"

static const uint kGroupThreads = 128;
static const uint kGroupVertices = kFollowTileStrands * kFollowRowVertices;

groupshared uint s_masks[32];
groupshared uint s_had[32];
groupshared uint s_count;
groupshared uint s_records;
groupshared uint s_list[512];

struct FollowSweep {
  SweptVertex swept;
  bool wanted;  // it is free, and finite; again: the walk has moved it
};

uint contactCount(uint bits) { return (bits & 1u) + ((bits >> 16) & 1u); }

// Path from the position in the last frame to the posed position.
FollowSweep firstSweep(uint follow, uint vertex, float4 now) {
  uint base = follow * g_followVertexCount;
  float3 root = g_followPositions[(g_firstFollow + follow) * g_followVertexCount].xyz;
  float3 rootBefore = g_followBefore[base].xyz;
  float3 before = g_followBefore[base + vertex].xyz;
  bool known = g_followHistory == 1u && isUsable(before);
  precise float3 to = now.xyz - g_followOrigin.xyz;
  precise float3 from = before - g_followOrigin.xyz;
  precise float3 displacement = to - from;
  precise float3 relative = displacement - (root - rootBefore);
  FollowSweep sweep;
  sweep.swept.from = known ? from : to;
  sweep.swept.to = to;
  sweep.swept.relative = float3(0.0, 0.0, 0.0);
  if (known) sweep.swept.relative = isUsable(relative) ? relative : displacement;
  sweep.swept.begin = known ? 0.0 : 1.0;
  sweep.swept.end = 1.0;
  sweep.swept.range = kFollowRange;
  sweep.swept.root = float3(0.0, 0.0, 0.0);
  sweep.swept.share = 0.0;
  sweep.wanted = now.w > 0.0 && isUsable(now.xyz);
  return sweep;
}

float3 inFront(float3 p, FollowContact contact) {
  precise float depth = contact.plane.w - dot3(contact.plane.xyz, p);
  precise float3 pushed = p + contact.plane.xyz * max(depth, 0.0);
  return pushed;
}

// Path from the posed position, in front of its planes, to where the walk has put the vertex.
// \param had  its contacts: bits 0 and 16
FollowSweep furtherSweep(uint follow, uint vertex, float4 now, uint had) {
  float3 evaluated =
      g_followBefore[followEvaluatedFrom() + follow * g_followVertexCount + vertex].xyz;
  precise float3 to = now.xyz - g_followOrigin.xyz;
  precise float3 from = evaluated - g_followOrigin.xyz;
  precise float3 moved = to - from;
  uint index = followContactIndex(vertex, follow);
  for (uint k = 0; k < contactCount(had); ++k)
    from = inFront(from, g_followContacts[index + k * followEvaluatedFrom()]);
  precise float3 relative = to - from;
  precise float squared = dot3(moved, moved);
  FollowSweep sweep;
  sweep.swept.from = from;
  sweep.swept.to = to;
  sweep.swept.relative = relative;
  sweep.swept.begin = 1.0;
  sweep.swept.end = 1.0;
  // So that a vertex that a plane holds far outside finds its surface again.
  sweep.swept.range = kFollowRange + squareRoot(squared);
  sweep.swept.root = float3(0.0, 0.0, 0.0);
  sweep.swept.share = 0.0;
  sweep.wanted = now.w > 0.0 && isUsable(now.xyz) && isUsable(from) && squared > 0.0;
  return sweep;
}

FollowSweep sweepOf(uint follow, uint vertex, uint had) {
  float4 now = g_followPositions[(g_firstFollow + follow) * g_followVertexCount + vertex];
  if (g_followAgain == 1u) return furtherSweep(follow, vertex, now, had);
  return firstSweep(follow, vertex, now);
}

// The last position is now that of this frame. The walk does this for the root, which other groups
// read.
void goOn(uint follow, uint vertex) {
  if (g_followAgain == 1u || vertex == 0u) return;
  uint own = follow * g_followVertexCount + vertex;
  g_followBefore[own] = g_followPositions[g_firstFollow * g_followVertexCount + own];
}

FollowContact contactOf(Found found, SweptVertex swept) {
  FollowContact contact;
  precise float offset = dot3(found.contact.normal, swept.to) + found.contact.penetration;
  contact.plane = float4(found.contact.normal, offset);
  precise float3 hold = swept.from + found.contact.surfaceMotion;
  contact.hold = float4(hold, swept.begin < 1.0 ? found.contact.friction : 0.0);
  return contact;
}

// Writes the contacts of a vertex. Returns their bits 0 and 16.
uint findContacts(uint follow, uint vertex, uint had) {
  SweptVertex swept = sweepOf(follow, vertex, had).swept;
  Found first;
  Found second;
  findDeepest(swept, first, second);
  if (!(first.contact.penetration > -swept.range)) return 0u;
  bool more = second.contact.penetration > -swept.range;
  uint index = followContactIndex(vertex, follow);
  FollowContact a = contactOf(first, swept);
  FollowContact b = contactOf(second, swept);
  if (had != 0u) {
    // Friction acts relative to the last frame.
    float4 hold = g_followContacts[index].hold;
    a.hold = hold;
    b.hold = hold;
  }
  g_followContacts[index] = a;
  if (more) g_followContacts[index + followEvaluatedFrom()] = b;
  return more ? 0x10001u : 1u;
}

[numthreads(32, 4, 1)]
void find_follow_contacts(uint3 group : SV_GroupID, uint index : SV_GroupIndex) {
  bool again = g_followAgain == 1u;
  uint tile = group.x;
  bool listed = tile < g_followTileCount;
  uint marks = 0xffffffffu;
  if (again) {
    listed = tile < min(g_followWords[kFollowArguments], g_followTileCount);
    tile = listed ? min(g_followWords[followList() + tile], g_followTileCount - 1u) : 0u;
    marks = g_followWords[followMarks() + tile];
  }
  if (!listed) marks = 0u;
  uint firstVertex = group.y * kFollowRowVertices;
  uint firstStrand = tile * kFollowTileStrands;
  if (index < kFollowTileStrands) {
    uint follow = firstStrand + index;
    bool inside = ((marks >> index) & 1u) != 0u && follow < g_followHairCount &&
                  firstVertex < g_followVertexCount;
    uint had = again && inside ? g_followWords[followMaskWord(group.y, follow)] : 0u;
    s_had[index] = had;
    s_masks[index] = had;
  }
  if (index == 0u) {
    s_count = 0u;
    s_records = 0u;
    if (!again && listed && group.y == 0u) g_followWords[followMarks() + tile] = 0u;
  }
  GroupMemoryBarrierWithGroupSync();

  for (uint pair = index; pair < kGroupVertices; pair += kGroupThreads) {
    uint strand = pair / kFollowRowVertices;
    uint bit = pair % kFollowRowVertices;
    uint follow = firstStrand + strand;
    uint vertex = firstVertex + bit;
    bool inside = ((marks >> strand) & 1u) != 0u && follow < g_followHairCount &&
                  vertex < g_followVertexCount;
    if (!inside) continue;
    uint own = follow * g_followVertexCount + vertex;
    if (!again)
      g_followBefore[followEvaluatedFrom() + own] =
          g_followPositions[g_firstFollow * g_followVertexCount + own];
    FollowSweep sweep = sweepOf(follow, vertex, s_had[strand] >> bit);
    if (sweep.wanted && mayCollide(sweep.swept)) {
      uint entry;
      InterlockedAdd(s_count, 1u, entry);
      s_list[entry] = pair;
    } else {
      goOn(follow, vertex);
    }
  }
  GroupMemoryBarrierWithGroupSync();

  uint wanted = s_count;
  [loop] for (uint entry = index; entry < wanted; entry += kGroupThreads) {
    uint pair = s_list[entry];
    uint strand = pair / kFollowRowVertices;
    uint bit = pair % kFollowRowVertices;
    uint bits = findContacts(firstStrand + strand, firstVertex + bit, s_had[strand] >> bit);
    goOn(firstStrand + strand, firstVertex + bit);
    if (bits == 0u) continue;
    InterlockedAnd(s_masks[strand], ~(0x10001u << bit));
    InterlockedOr(s_masks[strand], bits << bit);
    InterlockedAdd(s_records, contactCount(bits));
  }
  GroupMemoryBarrierWithGroupSync();
  if (index < kFollowTileStrands) {
    uint follow = firstStrand + index;
    bool inside = ((marks >> index) & 1u) != 0u && follow < g_followHairCount &&
                  firstVertex < g_followVertexCount;
    if (inside) g_followWords[followMaskWord(group.y, follow)] = s_masks[index];
  }
  if (index == 0u && s_records > 0u) InterlockedAdd(g_followWords[kFollowRecords], s_records);
}
