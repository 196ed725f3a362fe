// Moves stored follow strands out of signed distance fields and capsules, and keeps their lengths.
//
// Threads: one a follow strand, in groups of 32; groups of y > 0 have nothing to do, so that the
//          groups of update_follow_strands' indirect dispatch are right here, too.
// Reads:   g_followPositions, g_followFields, g_followKeys, g_followSurface, g_followColliders,
//          g_followBefore
// Writes:  g_followPositions and g_followTangents of strands that something touches, g_followBefore
//
// From the root to the tip. A vertex starts where update_follow_strands has placed it; once one
// before it was moved, where the placed direction from that one leads with the placed length. What
// it touches moves it out along its way since the last frame, swept as collide_vertices says, and
// its segment takes its length again in the plane of the contact. From there friction takes it back
// towards where it was, along that plane, by at most the coefficient times the way outwards. What
// all that leads into moves it out, with the length again: kFollowRounds times in all, of which the
// last leaves the length as it is. A vertex is outside in any case; a segment is off its length
// where its two ends cannot both be (a root that is deep inside).
//
// There is no velocity: a strand is placed anew in every frame. Friction that acts after the length
// holds what is within its reach where it was, so that a strand at rest stays; before the length,
// what it held back the length would let slide again. A sweep that stopped behind an obstacle
// cannot hold a strand there, as the length draws it along.
//
// Invariant (tests/kernel): vertices without inverse mass and strands that nothing touches keep
// their bits; what is inside is outside by the margin afterwards (99.9 %).
#define SDF_KEYS g_followKeys
#define SDF_SURFACE g_followSurface
#define SDF_CLOSEST_FEATURE 1
#define SDF_FRICTION 0

#include "../layouts/follow_collision.hlsli"
#include "../contact/fit_along_plane.hlsli"
#include "sdf_strand_contact.hlsli"
#include "sdf_vertex.hlsli"

static const uint kFollowRounds = 3;
static const uint kFollowMaxVertices = 256;

void collideWithCapsule(inout SdfVertex vertex, Collider shape, float begin) {
  Contact contact = findContact(shape, vertex.now, begin, 1.0);
  if (!(contact.penetration > 0.0)) return;
  precise float3 now = vertex.now + contact.normal * contact.penetration;
  if (!isUsable(now)) return;
  precise float grip = vertex.grip + contact.friction * contact.penetration;
  vertex.now = now;
  vertex.normal = contact.normal;
  vertex.carried = contact.surfaceMotion;
  vertex.grip = grip;
  vertex.moved = true;
}

// \param begin  share of the frame at which the vertex is at `before`
void collideWithAll(inout SdfVertex vertex, float begin) {
#if SDF
  for (uint f = 0; f < g_followFieldCount; ++f)
    collideWithField(vertex, g_followFields[f], begin, 1.0);
#endif
  for (uint c = 0; c < g_followColliderCount; ++c)
    collideWithCapsule(vertex, g_followColliders[c], begin);
}

// Back along the plane of the contact, towards where the vertex was.
float3 holdBack(SdfVertex vertex, float3 before) {
  precise float3 way = vertex.now - before - vertex.carried;
  precise float off = dot3(way, vertex.normal);
  precise float3 slip = way - vertex.normal * off;
  precise float size = squareRoot(dot3(slip, slip));
  precise float share = size > vertex.grip ? vertex.grip / size : 1.0;
  precise float3 held = vertex.now - slip * share;
  return held;
}

float3 fitLength(float3 place, float3 normal, float3 anchor, float segment) {
  precise float3 arm = place - anchor;
  precise float3 fitted = anchor + fitAlongPlane(arm, normal, segment);
  return fitted;
}

// Where a vertex goes. \param anchor  the vertex before it, \param segment  length from there.
SdfVertex resolve(float3 place, float3 before, bool known, float3 anchor, float segment,
                  bool anchored) {
  SdfVertex vertex;
  vertex.now = place;
  vertex.normal = float3(0.0, 0.0, 0.0);
  bool touched = false;
  [loop] for (uint round = 0; round < kFollowRounds; ++round) {
    bool first = round == 0 && known;
    vertex.before = vertex.now;
    if (first) vertex.before = before;
    vertex.carried = float3(0.0, 0.0, 0.0);
    vertex.grip = 0.0;
    vertex.moved = false;
    collideWithAll(vertex, first ? 0.0 : 1.0);
    if (!vertex.moved) break;
    touched = true;
    bool last = round + 1u == kFollowRounds;
    if (anchored && !last) vertex.now = fitLength(vertex.now, vertex.normal, anchor, segment);
    if (!first) continue;
    vertex.now = holdBack(vertex, before);
    if (anchored) vertex.now = fitLength(vertex.now, vertex.normal, anchor, segment);
  }
  vertex.moved = touched;
  return vertex;
}

[numthreads(32, 1, 1)]
void collide_follow_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint follow = group.x * 32u + lane;
  uint count = g_followVertexCount;
  if (group.y > 0u || follow >= g_followStrandCount || count > kFollowMaxVertices) return;
  uint first = (g_firstFollow + follow) * count;
  uint firstBefore = follow * count;
  float3 placedLast = float3(0.0, 0.0, 0.0);  // of the vertex before, as it was placed
  float3 last = float3(0.0, 0.0, 0.0);        // the same, and of the one before that, now
  float3 beforeLast = float3(0.0, 0.0, 0.0);
  bool usableLast = false;
  bool shifted = false;  // the vertex before is not where it was placed
  bool changed = false;  // something of the strand was moved
  for (uint vertex = 0; vertex < count; ++vertex) {
    float4 placed = g_followPositions[first + vertex];
    bool usable = isUsable(placed.xyz);
    precise float3 start = placed.xyz - g_followOrigin.xyz;
    float3 place = start;
    bool moved = false;
    if (usable && placed.w > 0.0) {
      precise float3 arm = start - placedLast;
      precise float segment = squareRoot(dot3(arm, arm));
      if (shifted) {
        precise float3 bent = last + directionOr(start - last, arm) * segment;
        place = segment > 0.0 ? bent : last;
      }
      precise float3 before = g_followBefore[firstBefore + vertex].xyz - g_followOrigin.xyz;
      bool known = g_followHistory == 1u && isUsable(before);
      SdfVertex resolved = resolve(place, before, known, last, segment, usableLast);
      moved = shifted || resolved.moved;
      place = resolved.now;
    }
    float3 now = place;
    float4 world = placed;
    if (moved) {
      precise float3 there = place + g_followOrigin.xyz;
      world = float4(there, placed.w);
      g_followPositions[first + vertex] = world;
    }
    g_followBefore[firstBefore + vertex] = world;
    changed = changed || moved;
    if (changed && vertex > 0u) {
      // That of a vertex is from the one before to the one after.
      uint of = first + vertex - 1u;
      float3 from = vertex > 1u ? beforeLast : last;
      precise float3 across = now - from;
      float3 tangent = directionOr(across, g_followTangents[of].xyz);
      g_followTangents[of] = float4(tangent, 0.0);
    }
    if (changed && vertex + 1u == count) {
      precise float3 across = now - last;
      float3 tangent = directionOr(across, g_followTangents[first + vertex].xyz);
      g_followTangents[first + vertex] = float4(tangent, 0.0);
    }
    beforeLast = last;
    last = now;
    placedLast = start;
    usableLast = usable;
    shifted = moved;
  }
}
