// Finds the contacts of vertices with capsules and SDFs before a solver takes its sub-step.
//
// Threads: one per vertex. A group of 32 x 4 has 32 vertices of 4 strands: group.x is a tile of 32
//          strands (or an entry of a list of tiles), group.y counts the 8 groups of 4 strands, then
//          the words of the masks, then rows of 32,768 tiles. In a second search group.x and rows
//          in group.z count groups of 4 strands of a list, and group.y the words of the masks.
// Reads:   g_contactPositions, g_contactRoots, g_awakeTiles, g_capsules; with SDF in its place
//          g_contactColliders, g_contactSdfKeys, g_contactSdfSurface
// Writes:  g_contacts, g_contactWords
//
// The kernel predicts that a vertex goes on as in the last sub-step, and that near the root it
// follows a change of the root's motion. It sweeps the vertex from its current to its predicted
// position. The vertex gets a record for each of the (at most kMaxContacts, deepest) colliders
// within g_contactRange, plus a quarter of its displacement relative to the root (in a second
// search: all of it), of the predicted position. If it had a record with the same collider, the
// forces are kept: the solver starts from them. In a second search, for listed strands, vertices
// are swept to where the solver has put them.
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
#define CONTACT_LOOKS 2
#define CONTACT_RESTS false
#include "deepest_contacts.hlsli"

static const uint kNoElement = 0xffffffffu;
// Maximum displacement that the prediction extrapolates [m].
static const float kLongestStep = 1.0;

groupshared uint s_masks[4];
groupshared uint s_count;
groupshared uint s_list[128];
groupshared float3 s_from[128];
groupshared float3 s_to[128];
groupshared float s_range[128];
groupshared uint s_element[128];
groupshared uint s_scratch[128];
groupshared uint s_had[4];

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
void storeScratch(uint entry, ContactRecord a, ContactRecord b, bool more) {
  uint element =
      g_contactBefore + g_contactVertexCount + 2u * g_contactStrandTotal + s_scratch[entry];
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
uint findRecords(uint entry) {
  SweptVertex swept;
  swept.from = s_from[entry];
  swept.to = s_to[entry];
  swept.relative = float3(0.0, 0.0, 0.0);
  swept.begin = g_contactBegin;
  swept.end = g_contactEnd;
  swept.range = s_range[entry];
  Found first;
  Found second;
  findDeepest(swept, first, second);
  if (!(first.contact.penetration > -swept.range)) return 0u;
  bool more = second.contact.penetration > -swept.range;
  uint strand = s_list[entry] >> 5;
  bool had = ((s_had[strand] >> (s_list[entry] & 31u)) & 1u) != 0u;
  uint element = s_element[entry] * kMaxContacts;
  ContactRecord a = goOn(recordOf(first, swept.to), element, had);
  ContactRecord b = goOn(recordOf(second, swept.to), element, had && more);
  if (more) a.bits = a.bits | kContactMore;
  storeRecord(element, a);
  if (more) storeRecord(element + 1u, b);
  if (g_contactStride > 0u) storeScratch(entry, a, b, more);
  return more ? 2u : 1u;
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

[numthreads(32, 4, 1)]
void find_contacts(uint3 group : SV_GroupID, uint3 lane : SV_GroupThreadID,
                   uint index : SV_GroupIndex) {
  bool again = (g_contactFlags & kAgainFlag) != 0u;
  uint blocks = (kTileStrands / kGroupStrands) * g_contactMaskWords;
  uint row = group.y / blocks;
  uint block = group.y - row * blocks;
  uint word = block / (kTileStrands / kGroupStrands);
  uint quarter = block - word * (kTileStrands / kGroupStrands);
  uint tile = row * kRowGroups + group.x;
  if (!again && (g_contactFlags & kListedFlag) != 0u)
    tile = g_awakeTiles[g_tileList + min(tile, g_contactTileCount - 1u)];
  uint slot = tile * kTileStrands + quarter * kGroupStrands + lane.y;
  bool inside = tile < g_contactTileCount;
  if (again) {
    uint entry = (group.z * kListedGroups + group.x) * kGroupStrands + lane.y;
    word = group.y;
    uint strand = 0u;
    if (entry < g_contactWords[g_contactHead + kContactListed])
      strand = g_contactWords[g_contactList + entry];
    inside = (strand & kListedFar) != 0u;
    slot = strand & ~kListedFar;
  }
  inside = inside && slot < g_contactStrandCount;
  uint maskWord = g_contactMasks + slot * g_contactMaskWords + word;
  if (index == 0u) s_count = 0u;
  if (lane.x == 0u) {
    s_masks[lane.y] = 0u;
    bool goesOn = again || (g_contactFlags & kNoHistoryFlag) == 0u;
    s_had[lane.y] = inside && goesOn ? g_contactWords[maskWord] : 0u;
  }
  GroupMemoryBarrierWithGroupSync();

  uint vertex = word * 32u + lane.x;
  uint own = kNoElement;
  if (inside) {
    ContactStrand strand = strandAt(slot);
    uint element = strand.target + vertex;
    if (vertex < strand.count && element < g_contactVertexCount) own = element;
  }
  if (own != kNoElement && vertex >= 2u) {
    ContactStrand strand = strandAt(slot);
    float3 now = g_contactPositions[own].xyz;
    float3 before = asfloat(g_contacts[g_contactBefore + own].xyz);
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
    // In a second search the prediction was wrong by much, so more of the vertices may collide.
    precise float range =
        g_contactRange + (again ? 1.0 : 0.25) * squareRoot(dot3(relative, relative));
    SweptVertex swept;
    swept.from = from;
    swept.to = to;
    swept.relative = relative;
    swept.begin = g_contactBegin;
    swept.end = g_contactEnd;
    swept.range = range;
    if (isUsable(to) && mayCollide(swept)) {
      uint entry;
      InterlockedAdd(s_count, 1u, entry);
      s_list[entry] = lane.y * 32u + lane.x;
      s_from[entry] = from;
      s_to[entry] = to;
      s_range[entry] = range;
      s_element[entry] = own;
      s_scratch[entry] = strand.state + vertex * kTileStrands;
    }
  }
  GroupMemoryBarrierWithGroupSync();

  if (index < s_count) {
    uint records = findRecords(index);
    if (records > 0u) {
      uint which = s_list[index];
      InterlockedOr(s_masks[which >> 5], 1u << (which & 31u));
      InterlockedAdd(g_contactWords[kContactCount], records);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  if (lane.x == 0u && inside) g_contactWords[maskWord] = s_masks[lane.y];
  if (own != kNoElement && !again)
    g_contacts[g_contactBefore + own] = uint4(asuint(g_contactPositions[own].xyz), 0u);
}
