// Finds the contacts of stored follow strands with capsules and SDFs before collide_follow_strands walks
// along them.
//
// Threads: a group of 32 x 4 has 16 vertices of 32 strands: group.x is a tile of 32 strands (or an entry of
//          the list of them), group.y a row of 16 vertices. These are the groups of
//          update_follow_strands' indirect dispatch, too.
// Reads:   g_followPositions, g_followBefore, g_followContacts (again), g_followWords,
//          g_followColliders, g_followFields, g_followKeys, g_followSurface
// Writes:  g_followContacts, g_followWords, g_followBefore but for the first vertex of a strand
//
// A vertex is swept from where it was at the end of the last frame to where it was placed, and gets a
// contact with each of the (at most two, the deepest) colliders that are within kFollowReach of that.
// Again, for the marked strands, those that the walk has moved are swept to where it has put them, from
// where they were placed and pushed out. One that nothing is near to there keeps what was found first.
//
// A group first asks which of its vertices may be near a collider, which costs a look at a key or
// at a capsule, and then shares out the queries among its threads.
//
// Invariant (tests/kernel): a vertex without a contact is farther than kFollowReach from every collider;
// positions stay as they are.
// SDF: with SDFs; without it there are capsules alone.
#include "../layouts/follow_collision.hlsli"
#if SDF
#define SDF_KEYS g_followKeys
#define SDF_SURFACE g_followSurface
#endif
#define CONTACT_CAPSULES g_followColliders
#define CONTACT_CAPSULE_COUNT g_followColliderCount
#define CONTACT_FIELDS g_followFields
#define CONTACT_FIELD_COUNT g_followFieldCount
// A vertex is where it was placed, not where it is expected; and in every frame it is placed anew on the far
// side of what it lies on.
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

// From where the vertex was in the last frame to where it was placed.
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
  sweep.swept.reach = kFollowReach;
  sweep.wanted = now.w > 0.0 && isUsable(now.xyz);
  return sweep;
}

float3 inFront(float3 p, FollowContact contact) {
  precise float depth = contact.plane.w - dot3(contact.plane.xyz, p);
  precise float3 pushed = p + contact.plane.xyz * max(depth, 0.0);
  return pushed;
}

// From where it was placed, in front of its planes, to where the walk has put it.
// \param had  its contacts: bits 0 and 16
FollowSweep furtherSweep(uint follow, uint vertex, float4 now, uint had) {
  float3 placed =
      g_followBefore[followPlacedFrom() + follow * g_followVertexCount + vertex].xyz;
  precise float3 to = now.xyz - g_followOrigin.xyz;
  precise float3 from = placed - g_followOrigin.xyz;
  precise float3 moved = to - from;
  uint index = followContactIndex(vertex, follow);
  for (uint k = 0; k < contactCount(had); ++k)
    from = inFront(from, g_followContacts[index + k * followPlacedFrom()]);
  precise float3 relative = to - from;
  precise float squared = dot3(moved, moved);
  FollowSweep sweep;
  sweep.swept.from = from;
  sweep.swept.to = to;
  sweep.swept.relative = relative;
  sweep.swept.begin = 1.0;
  sweep.swept.end = 1.0;
  // So that what a plane holds far outside finds its surface again.
  sweep.swept.reach = kFollowReach + squareRoot(squared);
  sweep.wanted = now.w > 0.0 && isUsable(now.xyz) && isUsable(from) && squared > 0.0;
  return sweep;
}

FollowSweep sweepOf(uint follow, uint vertex, uint had) {
  float4 now = g_followPositions[(g_firstFollow + follow) * g_followVertexCount + vertex];
  if (g_followAgain == 1u) return furtherSweep(follow, vertex, now, had);
  return firstSweep(follow, vertex, now);
}

// What was is now that of this frame. The walk does so for the root, which other groups read.
void goOn(uint follow, uint vertex) {
  if (g_followAgain == 1u || vertex == 0u) return;
  uint own = follow * g_followVertexCount + vertex;
  g_followBefore[own] = g_followPositions[g_firstFollow * g_followVertexCount + own];
}

FollowContact contactOf(Found found, SweptVertex swept) {
  FollowContact contact;
  precise float offset =
      dot3(found.contact.normal, swept.to) + found.contact.penetration;
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
  if (!(first.contact.penetration > -swept.reach)) return 0u;
  bool more = second.contact.penetration > -swept.reach;
  uint index = followContactIndex(vertex, follow);
  FollowContact a = contactOf(first, swept);
  FollowContact b = contactOf(second, swept);
  if (had != 0u) {
    // Friction is from the last frame on.
    float4 hold = g_followContacts[index].hold;
    a.hold = hold;
    b.hold = hold;
  }
  g_followContacts[index] = a;
  if (more) g_followContacts[index + followPlacedFrom()] = b;
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
    bool inside = ((marks >> index) & 1u) != 0u && follow < g_followStrandCount &&
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
    bool inside = ((marks >> strand) & 1u) != 0u && follow < g_followStrandCount &&
                  vertex < g_followVertexCount;
    if (!inside) continue;
    uint own = follow * g_followVertexCount + vertex;
    if (!again)
      g_followBefore[followPlacedFrom() + own] =
          g_followPositions[g_firstFollow * g_followVertexCount + own];
    FollowSweep sweep = sweepOf(follow, vertex, s_had[strand] >> bit);
    if (sweep.wanted && mayTouch(sweep.swept)) {
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
    bool inside = ((marks >> index) & 1u) != 0u && follow < g_followStrandCount &&
                  firstVertex < g_followVertexCount;
    if (inside) g_followWords[followMaskWord(group.y, follow)] = s_masks[index];
  }
  if (index == 0u && s_records > 0u) InterlockedAdd(g_followWords[kFollowRecords], s_records);
}
