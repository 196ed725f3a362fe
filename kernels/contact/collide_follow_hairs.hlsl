// Moves stored follow hairs out of the contacts of find_follow_contacts, and keeps their lengths.
//
// Threads: one per follow hair, in groups of 32, which are a tile (or an entry of the list of
//          tiles); groups of y > 0 do nothing, so that the dispatch of find_follow_contacts works
//          here, too.
// Reads:   g_followBefore (posed), g_followContacts, g_followWords
// Writes:  g_followPositions and g_followTangents of strands with a contact, g_followBefore of
//          these and of the first vertices, g_followWords (marks)
//
// The thread walks from the first vertex with a contact to the tip. A vertex starts where
// update_follow_hairs has posed it; after an earlier vertex has moved, it starts in the posed
// direction from the previous vertex, at the posed length. Its planes move it out, and its segment
// gets its length again along the plane. From there friction moves it back towards its sticking
// position, along that plane, by at most the coefficient times the outward displacement. Then the
// planes and the length are applied again: kFollowRounds times in all, the last time without the
// length. A vertex is outside in any case; a segment has the wrong length where its two ends cannot
// satisfy both (next to a root that is deep inside).
//
// A strand is marked if a vertex ends farther than kFollowError from where its contacts were found
// (its posed position, in front of its planes): contacts are found once more, where the walk has
// put the vertices, and the strand walks again from its posed vertices.
//
// Follow hairs have no velocity: a strand is posed anew in every frame. Friction is applied after
// the length, so that it holds vertices in its range at their last position and a strand at rest
// stays; before the length, the length would let them slide again. A sweep that stopped behind an
// obstacle cannot hold a strand there, because the length pulls it along.
//
// Invariant (tests/contact): vertices without inverse mass and strands without contact keep their
// bits; vertices that were inside are outside by the margin afterwards (99.9 %).
#include "layouts/follow_collision.hlsli"
#include "fit_along_plane.hlsli"

static const uint kFollowRounds = 3;
static const uint kFollowMaxVertices = 256;
// A vertex at most this deep is in front of a plane: rounding of the length [m].
static const float kFollowTolerance = 1e-7;

struct Step {
  float4 evaluated;  // world position; w inverse mass
  uint contacts;
  FollowContact first;
  FollowContact second;
};

struct Walked {
  float3 now;
  float3 normal;  // of the last contact
  float3 hold;    // where it would be if it stuck to that
  float grip;     // sum over the contacts of friction times the displacement outwards [m]
  bool moved;
};

Step loadStep(uint follow, uint vertex, uint word) {
  Step step;
  step.evaluated = g_followBefore[followEvaluatedFrom() + follow * g_followVertexCount + vertex];
  uint bits = word >> (vertex % kFollowRowVertices);
  step.contacts = (bits & 1u) + ((bits >> 16) & 1u);
  step.first.plane = float4(0.0, 0.0, 0.0, 0.0);
  step.first.hold = float4(0.0, 0.0, 0.0, 0.0);
  step.second = step.first;
  uint index = followContactIndex(vertex, follow);
  if (step.contacts > 0u) step.first = g_followContacts[index];
  if (step.contacts > 1u) step.second = g_followContacts[index + followEvaluatedFrom()];
  return step;
}

// A step without a contact has planes of zeros, and no vertex is behind these.
void pushOut(inout Walked vertex, FollowContact contact) {
  precise float depth = contact.plane.w - dot3(contact.plane.xyz, vertex.now);
  if (!(depth > kFollowTolerance)) return;
  precise float3 now = vertex.now + contact.plane.xyz * depth;
  if (!isUsable(now)) return;
  precise float grip = vertex.grip + contact.hold.w * depth;
  vertex.now = now;
  vertex.normal = contact.plane.xyz;
  vertex.hold = contact.hold.xyz;
  vertex.grip = grip;
  vertex.moved = true;
}

// Moves a vertex back along the plane of the contact.
float3 holdBack(Walked vertex) {
  precise float3 displacement = vertex.now - vertex.hold;
  precise float off = dot3(displacement, vertex.normal);
  precise float3 slip = displacement - vertex.normal * off;
  precise float size = squareRoot(dot3(slip, slip));
  precise float share = size > vertex.grip ? vertex.grip / size : 1.0;
  precise float3 held = vertex.now - slip * share;
  return held;
}

float3 fitLength(float3 p, float3 normal, float3 anchor, float segment) {
  precise float3 arm = p - anchor;
  precise float3 fitted = anchor + fitAlongPlane(arm, normal, segment);
  return fitted;
}

// Returns the new position of a vertex.
Walked resolve(float3 start, Step step, float3 anchor, float segment, bool anchored) {
  Walked vertex;
  vertex.now = start;
  vertex.normal = float3(0.0, 0.0, 0.0);
  vertex.hold = float3(0.0, 0.0, 0.0);
  bool touched = false;
  [loop] for (uint round = 0; round < kFollowRounds && step.contacts > 0u; ++round) {
    vertex.grip = 0.0;
    vertex.moved = false;
    pushOut(vertex, step.first);
    pushOut(vertex, step.second);
    if (!vertex.moved) break;
    touched = true;
    bool last = round + 1u == kFollowRounds;
    if (anchored && !last) vertex.now = fitLength(vertex.now, vertex.normal, anchor, segment);
    if (round > 0u) continue;
    vertex.now = holdBack(vertex);
    if (anchored) vertex.now = fitLength(vertex.now, vertex.normal, anchor, segment);
  }
  vertex.grip = 0.0;
  vertex.moved = touched;
  return vertex;
}

// Returns true if the vertex is farther than kFollowError from where its contacts were found.
bool isElsewhere(float3 now, float3 evaluated, Step step) {
  precise float depth = step.first.plane.w - dot3(step.first.plane.xyz, evaluated);
  precise float3 found = evaluated + step.first.plane.xyz * max(depth, 0.0);
  precise float further = step.second.plane.w - dot3(step.second.plane.xyz, found);
  precise float3 off = now - found - step.second.plane.xyz * max(further, 0.0);
  return !(dot3(off, off) <= kFollowError * kFollowError);
}

// Marks a strand, and lists its tile once.
void mark(uint tile, uint lane) {
  uint others;
  InterlockedOr(g_followWords[followMarks() + tile], 1u << lane, others);
  InterlockedAdd(g_followWords[kFollowMarked], 1u);
  if (others != 0u) return;
  uint entry;
  InterlockedAdd(g_followWords[kFollowArguments], 1u, entry);
  g_followWords[followList() + entry] = tile;
}

// Returns the first vertex with a contact; the count if there is none.
uint firstWithContact(uint follow) {
  for (uint row = 0; row * kFollowRowVertices < g_followVertexCount; ++row) {
    uint bits = g_followWords[followMaskWord(row, follow)] & 0xffffu;
    if (bits != 0u) return row * kFollowRowVertices + firstbitlow(bits);
  }
  return g_followVertexCount;
}

void walk(uint follow, uint lane, uint tile) {
  bool again = g_followAgain == 1u;
  uint count = g_followVertexCount;
  uint begin = firstWithContact(follow);
  uint target = (g_firstFollow + follow) * count;
  uint own = follow * count;
  uint evaluatedFrom = followEvaluatedFrom() + own;
  if (!again) g_followBefore[own] = g_followBefore[evaluatedFrom];
  if (begin >= count) return;
  float3 evaluatedLast = float3(0.0, 0.0, 0.0);  // posed position of the previous vertex
  float3 last = float3(0.0, 0.0, 0.0);           // the same, and of the one before that, now
  float3 beforeLast = float3(0.0, 0.0, 0.0);
  bool usableLast = false;
  if (begin > 0u) {
    float3 world = g_followBefore[evaluatedFrom + begin - 1u].xyz;
    usableLast = isUsable(world);
    precise float3 p = world - g_followOrigin.xyz;
    evaluatedLast = p;
    last = p;
  }
  if (begin > 1u) {
    precise float3 p = g_followBefore[evaluatedFrom + begin - 2u].xyz - g_followOrigin.xyz;
    beforeLast = p;
  }
  bool shifted = false;  // the previous vertex is not at its posed position
  bool changed = again;  // something of the strand was moved
  bool elsewhere = false;
  uint word = g_followWords[followMaskWord(begin / kFollowRowVertices, follow)];
  Step next = loadStep(follow, begin, word);
  [loop] for (uint vertex = begin; vertex < count; ++vertex) {
    Step step = next;
    // Loads ahead of the chain of dependent steps.
    uint ahead = min(vertex + 1u, count - 1u);
    if (ahead % kFollowRowVertices == 0u)
      word = g_followWords[followMaskWord(ahead / kFollowRowVertices, follow)];
    next = loadStep(follow, ahead, word);
    float4 world = step.evaluated;
    bool usable = isUsable(world.xyz);
    precise float3 evaluated = world.xyz - g_followOrigin.xyz;
    float3 now = evaluated;
    bool moved = false;
    if (usable && world.w > 0.0) {
      precise float3 arm = evaluated - evaluatedLast;
      precise float segment = squareRoot(dot3(arm, arm));
      if (shifted) {
        precise float3 bent = last + directionOr(evaluated - last, arm) * segment;
        now = segment > 0.0 ? bent : last;
      }
      Walked walked = resolve(now, step, last, segment, usableLast);
      moved = shifted || walked.moved;
      now = walked.now;
      elsewhere = elsewhere || (moved && isElsewhere(now, evaluated, step));
    }
    if (moved) {
      precise float3 there = now + g_followOrigin.xyz;
      world = float4(there, world.w);
    }
    if (moved || again) {
      g_followPositions[target + vertex] = world;
      g_followBefore[own + vertex] = world;
    }
    changed = changed || moved;
    if (changed && vertex > 0u) {
      // The tangent of a vertex is the direction from the previous to the next one.
      uint of = target + vertex - 1u;
      float3 from = vertex > 1u ? beforeLast : last;
      precise float3 across = now - from;
      float3 tangent = directionOr(across, g_followTangents[of].xyz);
      g_followTangents[of] = float4(tangent, 0.0);
    }
    if (changed && vertex + 1u == count) {
      precise float3 across = now - last;
      float3 tangent = directionOr(across, g_followTangents[target + vertex].xyz);
      g_followTangents[target + vertex] = float4(tangent, 0.0);
    }
    beforeLast = last;
    last = now;
    evaluatedLast = evaluated;
    usableLast = usable;
    shifted = moved;
  }
  if (elsewhere && !again) mark(tile, lane);
}

[numthreads(32, 1, 1)]
void collide_follow_hairs(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tile = group.x;
  if (group.y > 0u || tile >= g_followTileCount || g_followVertexCount > kFollowMaxVertices) return;
  uint marks = 0xffffffffu;
  if (g_followAgain == 1u) {
    if (tile >= g_followWords[kFollowArguments]) return;
    tile = min(g_followWords[followList() + tile], g_followTileCount - 1u);
    marks = g_followWords[followMarks() + tile];
  }
  uint follow = tile * kFollowTileStrands + lane;
  if (((marks >> lane) & 1u) == 0u || follow >= g_followHairCount) return;
  walk(follow, lane, tile);
}
