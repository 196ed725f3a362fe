// Finds the contacts of vertices with capsules and SDFs before a solver takes its sub-step.
//
// Threads: one a vertex. A group of 32 x 4 has 32 vertices of 4 strands: group.x is a tile of 32
//          strands (or an entry of a list of them), group.y counts the 8 groups of 4 strands, then
//          the words of the masks, then rows of 32,768 tiles.
// Reads:   g_contactPositions, g_contactStrands, g_contactRoots, g_awakeTiles, g_capsules, g_fields, g_fieldKeys,
//          g_fieldSurface
// Writes:  g_contacts, g_contactWords, g_contactBefore
//
// A vertex is expected to go on as in the last sub-step, and near the root to follow the root where
// that changes its motion. It is swept from where it is to there, and gets a record for each of the
// (at most kMaxContacts, the deepest) colliders that are within g_contactReach, or a quarter of its
// displacement against the root (again: all of it), of where it is expected. Forces of the record that
// it had with the same collider go on: they are where the solver starts from.
// Again, for the strands that are marked, vertices are swept to where the solver has put them.
//
// A group first asks which of its vertices may be near a collider, which costs a look at a key or
// at a capsule, and then shares out the queries among its threads.
//
// Invariant (tests/contact): the same records for any order of strands; a vertex without a record
// is farther from every collider than the reach; a mask has a bit for each vertex with a record.
// SDF: with SDFs; without it there are capsules alone.
#include "../layouts/contact.hlsli"
#if SDF
#define SDF_KEYS g_fieldKeys
#define SDF_SURFACE g_fieldSurface
#endif
#define CONTACT_CAPSULES g_capsules
#define CONTACT_CAPSULE_COUNT g_capsuleCount
#define CONTACT_FIELDS g_fields
#define CONTACT_FIELD_COUNT g_fieldCount
#define CONTACT_LOOKS 2
#define CONTACT_RESTS false
#include "deepest_contacts.hlsli"

static const uint kTileStrands = 32;
static const uint kGroupStrands = 4;
static const uint kTilesARow = 32768;
static const uint kListedFlag = 1;
static const uint kAgainFlag = 2;
static const uint kNoHistoryFlag = 4;
static const uint kOddFlag = 8;
static const uint kNoElement = 0xffffffffu;
// Longest displacement that an expectation goes on with [m].
static const float kLongestStep = 1.0;

groupshared uint s_masks[4];
groupshared uint s_count;
groupshared uint s_list[128];
groupshared float3 s_from[128];
groupshared float3 s_to[128];
groupshared float s_reach[128];
groupshared uint s_element[128];
groupshared uint s_had[4];

// The force of the record that the vertex had with the same collider, in the new tangent plane.
ContactRecord goOn(ContactRecord record, uint first, bool had) {
  float3 n = record.plane.xyz;
  for (uint k = 0; k < kMaxContacts && had; ++k) {
    uint bits = g_contacts[first + k].bits;
    if ((bits & kContactCollider) == (record.bits & kContactCollider)) {
      float4 force = g_contacts[first + k].force;
      precise float off = dot3(force.xyz, n);
      precise float3 tangential = force.xyz - n * off;
      if (isUsable(tangential) && force.w >= 0.0 && force.w < 1e18) {
        record.force = float4(tangential, force.w);
        record.bits = record.bits | (bits & (kContactSticks | kContactSlides));
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

// Writes the records of a vertex. Returns how many.
uint findRecords(uint entry) {
  SweptVertex swept;
  swept.from = s_from[entry];
  swept.to = s_to[entry];
  swept.relative = float3(0.0, 0.0, 0.0);
  swept.begin = g_contactBegin;
  swept.end = g_contactEnd;
  swept.reach = s_reach[entry];
  Found first;
  Found second;
  findDeepest(swept, first, second);
  if (!(first.contact.penetration > -swept.reach)) return 0u;
  bool more = second.contact.penetration > -swept.reach;
  uint strand = s_list[entry] >> 5;
  bool had = ((s_had[strand] >> (s_list[entry] & 31u)) & 1u) != 0u;
  uint element = s_element[entry] * kMaxContacts;
  ContactRecord a = goOn(recordOf(first, swept.to), element, had);
  ContactRecord b = goOn(recordOf(second, swept.to), element, had && more);
  if (more) a.bits = a.bits | kContactMore;
  g_contacts[element] = a;
  if (more) g_contacts[element + 1u] = b;
  return more ? 2u : 1u;
}

// Element of g_contactBefore with the displacement of a strand's root.
uint rootStepIndex(uint place, bool last) {
  uint which = (g_contactFlags & kOddFlag) != 0u ? 1u : 0u;
  if (last) which = 1u - which;
  return g_contactVertexCount + which * g_contactStrandTotal + place;
}

// Displacement of a strand's root in the last sub-step, as far as in this one, and in this one.
struct RootSteps {
  float3 last;
  float3 now;
};

RootSteps rootSteps(ContactStrand strand, uint place) {
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
  precise float3 last = g_contactBefore[rootStepIndex(place, true)].xyz * g_contactRatio;
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
  uint tile = row * kTilesARow + group.x;
  bool listed = true;
  if (again) {
    listed = tile < min(g_contactWords[g_contactHead + kContactFindArguments], g_contactTileCount);
    tile = listed ? g_contactWords[g_contactList + tile] : 0u;
  } else if ((g_contactFlags & kListedFlag) != 0u) {
    tile = g_awakeTiles[g_tileList + min(tile, g_contactTileCount - 1u)];
  }
  uint place = tile * kTileStrands + quarter * kGroupStrands + lane.y;
  bool inside = listed && tile < g_contactTileCount && place < g_contactStrandCount;
  if (again && inside) {
    uint strands = g_contactWords[g_contactList + g_contactTileCount + tile];
    inside = ((strands >> (quarter * kGroupStrands + lane.y)) & 1u) != 0u;
  }
  uint maskWord = g_contactMasks + place * g_contactMaskWords + word;
  if (index == 0u) s_count = 0u;
  if (lane.x == 0u) {
    s_masks[lane.y] = 0u;
    bool goesOn = again || (g_contactFlags & kNoHistoryFlag) == 0u;
    s_had[lane.y] = inside && goesOn ? g_contactWords[maskWord] : 0u;
  }
  if (index == 0u && !again && inside && block == 0u)
    g_contactWords[g_contactList + g_contactTileCount + tile] = 0u;
  GroupMemoryBarrierWithGroupSync();

  uint vertex = word * 32u + lane.x;
  uint own = kNoElement;
  if (inside) {
    ContactStrand strand = g_contactStrands[place];
    uint element = strand.target + vertex;
    if (vertex < strand.count && element < g_contactVertexCount) own = element;
  }
  if (own != kNoElement && vertex >= 2u) {
    ContactStrand strand = g_contactStrands[place];
    float3 now = g_contactPositions[own].xyz;
    float3 before = g_contactBefore[own].xyz;
    bool known = (g_contactFlags & kNoHistoryFlag) == 0u && isUsable(before);
    RootSteps root = rootSteps(strand, place);
    if (vertex == 2u && !again) g_contactBefore[rootStepIndex(place, false)] = float4(root.now, 0.0);
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
    // Again the solve has gone wrong by much, so that more of them may meet a collider.
    precise float reach =
        g_contactReach + (again ? 1.0 : 0.25) * squareRoot(dot3(relative, relative));
    SweptVertex swept;
    swept.from = from;
    swept.to = to;
    swept.relative = relative;
    swept.begin = g_contactBegin;
    swept.end = g_contactEnd;
    swept.reach = reach;
    if (isUsable(to) && mayTouch(swept)) {
      uint entry;
      InterlockedAdd(s_count, 1u, entry);
      s_list[entry] = lane.y * 32u + lane.x;
      s_from[entry] = from;
      s_to[entry] = to;
      s_reach[entry] = reach;
      s_element[entry] = own;
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
    g_contactBefore[own] = float4(g_contactPositions[own].xyz, 0.0);
}
