// Finds the contacts of vertices with capsules and SDFs before a solver takes its sub-step.
//
// Threads: one per vertex. A group of 128 has as many whole strands as it has threads for, or 32
//          vertices of 4 longer ones: group.x is a tile of 32 strands (or an entry of a list of
//          tiles), group.y counts the groups of a tile, then the words of the masks, then rows of
//          32,768 tiles. In a second search group.x and rows in group.z count groups of 4 strands
//          of a list, and group.y the words of the masks.
// Reads:   g_contactPositions, g_contactRoots, g_awakeTiles, g_capsules; with SDF in its place
//          g_contactColliders, g_contactSdfKeys, g_contactSdfSurface
// Writes:  g_contacts, g_contactWords
//
// The kernel predicts that a vertex goes on as in the last sub-step, and that near the root it
// follows a change of the root's motion. It sweeps the vertex from its current to its predicted
// position. The vertex gets a record for each of the (at most kMaxContacts, deepest) colliders
// within g_contactRange, plus a quarter of its displacement and of that of the surface relative to
// the root (in a second search: all of them), of the predicted position. If it had a record with the
// same collider, the forces are kept: the solver starts from them. In a second search, for listed
// strands, vertices are swept to where the solver has put them.
//
// A group first tests which of its vertices may be near a collider, which costs one key or one
// capsule each, and then distributes the queries over its threads.
//
// Invariant (tests/contact): the same records for any order of strands; a vertex without a record
// is farther from every collider than the range; a mask has a bit for each vertex with a record.
// SDF: with SDFs; without it there are capsules alone. DENSE_SDF: also with SDFs of an engine.
#include "../base/dispatch.hlsli"
#include "layouts/contact.hlsli"
#include "contact_access.hlsli"
#if SDF
// In the short sub-steps of fast colliders, displacements that lead through thin plates are shorter.
#define SDF_SWEEP_FROM ((g_contactFlags & kFastFlag) != 0u ? 0.5 * kSdfSweepFrom : kSdfSweepFrom)
#define SDF_KEYS g_contactSdfKeys
#define SDF_SURFACE g_contactSdfSurface
#define SDF_ELEMENTS g_contactColliders
#include "../sdf/load_sdf.hlsli"
#define CONTACT_CAPSULE(c) capsuleAt(c)

Collider capsuleAt(uint c) {
  uint element = kColliderElements * (g_contactSdfCount + c);
  Collider capsule;
  capsule.head = asfloat(g_contactColliders[element]);
  capsule.tail = asfloat(g_contactColliders[element + 1u]);
  capsule.headBefore = asfloat(g_contactColliders[element + 2u]);
  capsule.tailBefore = asfloat(g_contactColliders[element + 3u]);
  capsule.spin = asfloat(g_contactColliders[element + 4u]);
  return capsule;
}
#else
#define CONTACT_CAPSULE(c) g_capsules[c]
#endif
#define CONTACT_CAPSULE_COUNT g_capsuleCount
#define CONTACT_SDF(f) loadSdf(f)
#define CONTACT_SDF_COUNT g_contactSdfCount
#define CONTACT_SDF_MOTION(f, sdf, p) guessedMotion(f, sdf, p)
#if SDF
float3 guessedMotion(uint f, Sdf sdf, float3 p);
#endif
#define CONTACT_LOOKS 2
#define CONTACT_RESTS false
#include "deepest_contacts.hlsli"

// Maximum displacement that the prediction extrapolates [m].
static const float kLongestStep = 1.0;

// [strand of the group]
groupshared uint s_masks[kTileStrands];
groupshared uint s_had[kTileStrands];
groupshared uint s_target[kTileStrands];
groupshared uint s_state[kTileStrands];
groupshared float3 s_root[kTileStrands];
groupshared uint s_records;
// Vertices that may be near a collider: 32 times the strand of the group, and the bit of the mask.
groupshared uint s_count;
groupshared uint s_list[kGroupThreads];
groupshared float4 s_from[kGroupThreads];  // w: range
groupshared float3 s_to[kGroupThreads];

#if SDF
// Motions of a few triangles of the first SDFs, of which one is near enough to a far vertex to tell
// how the surface moves there.
static const uint kGuesses = 4;
static const uint kGuessedSdfs = 4;
groupshared SdfGuess s_guesses[kGuesses * kGuessedSdfs];

SdfGuess guessAt(Sdf sdf, uint k) { return sdfGuessOf(sdf, sdf.triangleCount / kGuesses * k); }

// Before a barrier.
void prepareGuesses(uint index) {
  uint f = index / kGuesses;
  if (f < min(g_contactSdfCount, kGuessedSdfs))
    s_guesses[index] = guessAt(loadSdf(f), index % kGuesses);
}

// Returns about how an SDF moves in the frame near p [m].
float3 guessedMotion(uint f, Sdf sdf, float3 p) {
  precise float3 motion = float3(0.0, 0.0, 0.0);
  bool moves = (g_contactFlags & kMovingFlag) != 0u && sdfMoves(sdf) && isUsable(p);
  precise float3 at = (p - sdf.origin.xyz) * (1.0 / sdf.origin.w);
  float nearest = 1e18;
  for (uint k = 0; k < kGuesses && moves; ++k) {
    SdfGuess guess = s_guesses[kGuesses * min(f, kGuessedSdfs - 1u) + k];
    if (f >= kGuessedSdfs) guess = guessAt(sdf, k);
    precise float3 off = guess.at - at;
    precise float squared = dot3(off, off);
    if (squared < nearest) {
      nearest = squared;
      motion = guess.motion;
    }
  }
  return motion;
}
#endif

// In a second search the prediction was wrong by much, so more of the vertices may collide.
float shareOfRange() { return (g_contactFlags & kAgainFlag) != 0u ? 1.0 : 0.25; }

// Returns the force of the record that the vertex had with the same collider, in the new tangent
// plane.
ContactRecord goOn(ContactRecord record, uint first, bool had) {
  float3 n = record.plane.xyz;
  for (uint k = 0; k < kMaxContacts && had; ++k) {
    uint bits = contactBits(first + k);
    if ((bits & kContactCollider) == (record.bits & kContactCollider)) {
      float4 force = contactForce(first + k);
      precise float off = dot3(force.xyz, n);
      precise float3 tangential = force.xyz - n * off;
      if (isUsable(tangential) && force.w >= 0.0 && force.w < 1e18) {
        record.force = float4(tangential, force.w);
        if (force.w > 0.0) record.bits = record.bits | kContactPressed;
      }
      break;
    }
    if ((bits & kContactMore) == 0u) break;
  }
  return record;
}

ContactRecord recordOf(Found found, float3 to) {
  ContactRecord record;
  precise float distance = -found.contact.penetration;
  record.plane = float4(found.contact.normal, distance);
  record.surface = float4(found.contact.surfaceMotion, found.contact.friction);
  record.force = float4(0.0, 0.0, 0.0, 0.0);
  record.foundX = to.x;
  record.foundY = to.y;
  record.foundZ = to.z;
  record.bits = found.collider;
  return record;
}

void storeRecord(uint index, ContactRecord record) {
  uint element = kContactElements * index;
  g_contacts[element] = asuint(record.plane);
  g_contacts[element + 1u] = asuint(record.surface);
  g_contacts[element + 2u] = asuint(record.force);
  g_contacts[element + 3u] =
      uint4(asuint(record.foundX), asuint(record.foundY), asuint(record.foundZ), record.bits);
}

ContactStrand strandAt(uint slot) {
  uint word = g_contactStrands + 4u * slot;
  ContactStrand strand;
  strand.target = g_contactWords[word];
  strand.count = g_contactWords[word + 1u];
  strand.root = g_contactWords[word + 2u];
  strand.state = g_contactWords[word + 3u];
  return strand;
}

// Plane of a record in the scratch.
float4 planeOf(ContactRecord record) {
  precise float along = dot3(record.plane.xyz, record.surface.xyz);
  return float4(record.plane.xyz, record.force.w > 0.0 ? along : kNoLimit);
}

// Writes what the elimination needs of the records of a vertex.
// \param vertex  its element in a set of the scratch
void storeScratch(uint vertex, ContactRecord a, ContactRecord b, bool more) {
  uint element = g_contactBefore + g_contactVertexCount + 2u * g_contactStrandTotal + vertex;
  precise float3 force = a.plane.xyz * a.force.w + a.force.xyz;
  precise float load = squareRoot(dot3(force, force));
  float4 second = float4(0.0, 0.0, 0.0, kNoLimit);
  if (more) {
    second = planeOf(b);
    precise float3 other = b.plane.xyz * b.force.w + b.force.xyz;
    force = force + other;
    load = load + squareRoot(dot3(other, other));
  }
  g_contacts[element + kScratchPlanes * g_contactStride] = asuint(planeOf(a));
  g_contacts[element + (kScratchPlanes + 1u) * g_contactStride] = asuint(second);
  g_contacts[element + kScratchForces * g_contactStride] = asuint(float4(force, load));
}

// Writes the records of a vertex. Returns their number.
// \param firstVertex  of the mask's word
uint findRecords(uint entry, uint firstVertex) {
  SweptVertex swept;
  swept.from = s_from[entry].xyz;
  swept.to = s_to[entry];
  uint strand = s_list[entry] / kMaskVertices;
  uint bit = s_list[entry] % kMaskVertices;
  swept.relative = float3(0.0, 0.0, 0.0);
  swept.root = s_root[strand];
  swept.begin = g_contactBegin;
  swept.end = g_contactEnd;
  swept.range = s_from[entry].w;
  swept.share = shareOfRange();
  Found first;
  Found second;
  findDeepest(swept, first, second);
  uint count = 0u;
  if (first.collider != kContactCollider) {
    bool more = second.collider != kContactCollider;
    uint vertex = firstVertex + bit;
    bool had = ((s_had[strand] >> bit) & 1u) != 0u;
    uint element = (s_target[strand] + vertex) * kMaxContacts;
    ContactRecord a = goOn(recordOf(first, swept.to), element, had);
    ContactRecord b = goOn(recordOf(second, swept.to), element, had && more);
    if (more) a.bits = a.bits | kContactMore;
    storeRecord(element, a);
    if (more) storeRecord(element + 1u, b);
    if (g_contactStride > 0u) storeScratch(s_state[strand] + vertex * kTileStrands, a, b, more);
    count = more ? 2u : 1u;
  }
  return count;
}

// Element of g_contacts with the displacement of a strand's root.
uint rootStepIndex(uint slot, bool last) {
  uint which = (g_contactFlags & kOddFlag) != 0u ? 1u : 0u;
  if (last) which = 1u - which;
  return g_contactBefore + g_contactVertexCount + which * g_contactStrandTotal + slot;
}

// Displacement of a strand's root in the last sub-step, scaled to this one, and in this one.
struct RootSteps {
  float3 last;
  float3 now;
};

RootSteps rootSteps(ContactStrand strand, uint slot) {
  RootSteps steps;
  steps.last = float3(0.0, 0.0, 0.0);
  steps.now = float3(0.0, 0.0, 0.0);
  uint index = strand.root * 2u + 1u;
  if (strand.root >= g_contactRootCount) return steps;
  float share = g_contactEnd - g_contactBegin;
  precise float3 now =
      (g_contactRoots[index].xyz - g_contactRoots[index + g_contactRootCount * 2u].xyz) * share;
  if (isUsable(now) && dot3(now, now) < kLongestStep * kLongestStep) steps.now = now;
  steps.last = steps.now;
  if ((g_contactFlags & (kNoHistoryFlag | kAgainFlag)) != 0u) return steps;
  precise float3 last = asfloat(g_contacts[rootStepIndex(slot, true)].xyz) * g_contactRatio;
  steps.last = last;
  return steps;
}

[numthreads(kGroupThreads, 1, 1)]
void find_contacts(uint3 group : SV_GroupID, uint index : SV_GroupIndex) {
  bool again = (g_contactFlags & kAgainFlag) != 0u;
  uint groupVertices = again ? kMaskVertices : g_contactGroupVertices;
  uint groupStrands = again ? kListedStrands : g_contactGroupStrands;
  uint own = index / groupVertices;
  uint bit = index - own * groupVertices;
  uint blocks = g_contactTileGroups * g_contactMaskWords;
  uint row = group.y / blocks;
  uint block = group.y - row * blocks;
  uint word = block / g_contactTileGroups;
  uint part = block - word * g_contactTileGroups;
  uint tile = row * kRowGroups + group.x;
  if (!again && (g_contactFlags & kListedFlag) != 0u)
    tile = g_awakeTiles[g_tileList + min(tile, g_contactTileCount - 1u)];
  uint lane = part * groupStrands + own;
  uint slot = tile * kTileStrands + lane;
  bool inside = tile < g_contactTileCount && lane < kTileStrands;
  if (again) {
    uint entry = (group.z * kListedGroups + group.x) * kListedStrands + own;
    word = group.y;
    uint strand = 0u;
    if (entry < g_contactWords[g_contactHead + kContactListed])
      strand = g_contactWords[g_contactList + entry];
    inside = (strand & kListedFar) != 0u;
    slot = strand & ~kListedFar;
  }
  inside = inside && own < groupStrands && slot < g_contactStrandCount;
  uint maskWord = g_contactMasks + slot * g_contactMaskWords + word;
  uint firstVertex = word * kMaskVertices;
  ContactStrand strand = (ContactStrand)0;
  if (inside) strand = strandAt(slot);
  if (index == 0u) {
    s_count = 0u;
    s_records = 0u;
  }
  if (inside && bit == 0u) {
    bool goesOn = again || (g_contactFlags & kNoHistoryFlag) == 0u;
    s_masks[own] = 0u;
    s_had[own] = goesOn ? g_contactWords[maskWord] : 0u;
    s_target[own] = strand.target;
    s_state[own] = strand.state;
  }
#if SDF
  if ((g_contactFlags & kMovingFlag) != 0u) prepareGuesses(index);
#endif
  GroupMemoryBarrierWithGroupSync();

  uint vertex = firstVertex + bit;
  uint element = strand.target + vertex;
  bool exists = vertex < strand.count && element < g_contactVertexCount;
  if (exists && vertex >= 2u) {
    float3 now = g_contactPositions[element].xyz;
    float3 before = asfloat(g_contacts[g_contactBefore + element].xyz);
    bool known = (g_contactFlags & kNoHistoryFlag) == 0u && isUsable(before);
    RootSteps root = rootSteps(strand, slot);
    if (vertex == 2u && !again)
      g_contacts[rootStepIndex(slot, false)] = uint4(asuint(root.now), 0u);
    precise float3 displacement = now - before;
    if (!again) displacement = displacement * g_contactRatio;
    if (!known || !(dot3(displacement, displacement) < kLongestStep * kLongestStep))
      displacement = again ? root.now : float3(0.0, 0.0, 0.0);
    precise float3 relative = displacement - (again ? root.now : root.last);
    if (!known) relative = float3(0.0, 0.0, 0.0);
    precise float3 there = now - g_contactOrigin.xyz;
    precise float3 from = there;
    precise float3 to = there;
    if (again) {
      from = there - displacement;
    } else {
      precise float share = 1.0 - float(vertex) / float(strand.count);
      to = there + displacement + (root.now - root.last) * share + g_contactFall.xyz;
    }
    precise float range = g_contactRange + shareOfRange() * squareRoot(dot3(relative, relative));
    SweptVertex swept;
    swept.from = from;
    swept.to = to;
    swept.relative = relative;
    swept.root = root.now;
    swept.begin = g_contactBegin;
    swept.end = g_contactEnd;
    swept.range = range;
    swept.share = shareOfRange();
    if (bit == max(firstVertex, 2u) - firstVertex) s_root[own] = root.now;
    if (isUsable(to) && mayCollide(swept)) {
      uint entry;
      InterlockedAdd(s_count, 1u, entry);
      s_list[entry] = own * kMaskVertices + bit;
      s_from[entry] = float4(from, range);
      s_to[entry] = to;
    }
  }
  GroupMemoryBarrierWithGroupSync();

  if (index < s_count) {
    uint records = findRecords(index, firstVertex);
    if (records > 0u) {
      uint which = s_list[index];
      InterlockedOr(s_masks[which / kMaskVertices], 1u << (which % kMaskVertices));
      InterlockedAdd(s_records, records);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  if (inside && bit == 0u) g_contactWords[maskWord] = s_masks[own];
  if (exists && !again)
    g_contacts[g_contactBefore + element] = uint4(asuint(g_contactPositions[element].xyz), 0u);
  if (index == 0u && s_records > 0u) InterlockedAdd(g_contactWords[kContactCount], s_records);
}
