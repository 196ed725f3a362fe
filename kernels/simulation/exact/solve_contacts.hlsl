// The forces of the contacts of a strand, between eliminate_strands and roll_out_strands: iterations
// between Coulomb's law at each contact and the strand's linear response (exact_contact.hlsli).
//
// Threads: groups of 32 with one, two or four strands, of a list of eliminate_strands with 32, 16 or
//          8 lanes for each; in a second round one strand, of the list of roll_out_strands.
// Reads:   g_rest, g_state (gains), g_contacts, g_contactWords, g_sleep
// Writes:  g_contacts (forces of the records, scratch); g_state (k of the gains) if it sweeps
//
// The response is a matrix over the vertices in contact. The compliance C_i of the state
// (dx_i, dphi_i-1) to forces on it follows from root to tip as a covariance does in a Kalman filter:
//   C_i+1 = T C_i T^T + B W B^T,
// T the closed loop of edge i, B what its rotation does to the state, W the inverse of its pivot;
// what a force does further on, T takes there. Each lane of a strand has a vertex in contact: three
// columns of the matrix from there on, and in the iterations the contacts of the vertex. The first six
// also have the columns of C, the next one dx by the gains. A strand with more vertices in contact
// than the matrix has takes two sweeps in each iteration instead, by one lane.
//
// Invariant (tests/simulation): agrees with tests/reference/rod bit by bit where the device's square
// root and division are exact.
#define CONTACTS 1
#define VELOCITY_SHOCK_PROPAGATION 1
#include "../../base/dispatch.hlsli"
#include "exact_compliance.hlsli"

static const uint kLanes = 32;
static const uint kMostStrands = kLanes / kFewLanes;
// Lanes of the columns of C, and the lane of dx by the gains.
static const uint kComplianceLanes = 6;
static const uint kFreeLane = kComplianceLanes;
// Blocks of the lower triangle, by columns, in three arrays: few and wide loads. Those of a strand
// follow those of the one before it.
static const uint kBlocks = kMatrixContacts * (kMatrixContacts + 1) / 2;
groupshared float4 s_blocksA[kBlocks];
groupshared float4 s_blocksB[kBlocks];
groupshared float s_blocksC[kBlocks];
// [lane] change of the forces since the elimination.
groupshared float4 s_changes[kLanes];
groupshared float2 s_sums[kLanes];
groupshared float s_products[36 * kMostStrands];  // T C, by columns
// Three columns of C, and dx by the gains: dx and u.
groupshared float3 s_starts[8 * kMostStrands];

// A strand of a group, and where the group's memory has it.
struct GroupStrand {
  uint index;  // kNoStrand: there is none
  uint count;  // vertices in contact
  uint last;   // vertex in contact
  uint lane;   // of the strand's lanes
  uint firstLane;
  uint firstBlock;
  uint number;  // of the strand in the group
};

uint blockAt(GroupStrand own, uint row, uint column) {
  return own.firstBlock + row * (row + 1u) / 2u + column;
}

// A record in the iterations.
struct ContactSplit {
  float3 normal;
  float friction;
  float3 offset;  // R w0
  float weight;   // of the penalty
  float3 force;
  float forceBefore;  // size of the force in the elimination
  float3 residual;    // force of the penalty
};

ContactSplit noSplit() {
  ContactSplit split;
  split.normal = float3(0.0, 0.0, 0.0);
  split.friction = 0.0;
  split.offset = float3(0.0, 0.0, 0.0);
  split.weight = 0.0;
  split.force = float3(0.0, 0.0, 0.0);
  split.forceBefore = 0.0;
  split.residual = float3(0.0, 0.0, 0.0);
  return split;
}

// A vertex in contact in the iterate.
struct TouchState {
  float3 x;
  float weight;
  float3 moved;  // since the start of the step in world space
  float3 free;   // to where it would be alone
  float penalty;
};

TouchState loadState(uint vertex, ExactStrand strand) {
  RigidMotion transport;
  transport.rotation = loadScratch(kScratchStates, 0u, strand);
  transport.shift = loadScratch(kScratchStates, 1u, strand).xyz;
  float4 a = loadScratch(kScratchStates, vertex, strand);
  TouchState state;
  state.x = a.xyz;
  state.weight = a.w;
  float3 displacement = loadScratch(kScratchStates + 1u, vertex, strand).xyz;
  state.moved = worldDisplacement(transport, a.xyz, displacement);
  state.free = loadScratch(kScratchStates + 2u, vertex, strand).xyz;
  state.penalty = max(a.w, leastWeight(strand));
  return state;
}

struct Begin {
  ContactSplit split;
  float3 change;  // of the force since the elimination
  float4 found;   // where, and the distance of the plane
  bool more;      // one more record follows
};

// Returns the first iterate of a record's force.
Begin beginForce(uint record, TouchState state) {
  uint element = kContactElements * record;
  float4 plane = asfloat(g_contacts[element]);
  float4 surface = asfloat(g_contacts[element + 1u]);
  float4 stored = asfloat(g_contacts[element + 2u]);
  uint4 found = g_contacts[element + 3u];
  float3 n = plane.xyz;
  precise float gap = plane.w + dot3(n, state.x - asfloat(found.xyz));
  float3 slip = tangentialPart(n, state.moved - surface.xyz);
  precise float3 before = n * stored.w + stored.xyz;
  precise float3 force = before;
  // A first force: the one that the vertex alone needs.
  precise float alone = gap + dot3(n, state.free);
  if (!(stored.w > 0.0) && gap < kContactDistance && alone < 0.0) {
    precise float3 slipAlone = slip + tangentialPart(n, state.free);
    precise float3 needed = (n * -alone - slipAlone) * state.weight;
    force = projected(n, surface.w, needed);
  }
  precise float3 w0 = n * gap + slip;
  Begin begin;
  begin.split.normal = n;
  begin.split.friction = surface.w;
  begin.split.offset = penalized(n, state.penalty, w0);
  begin.split.weight = state.penalty;
  begin.split.force = force;
  begin.split.forceBefore = lengthOf(before);
  precise float3 trial = force - begin.split.offset;
  float3 pull = projected(n, surface.w, trial);
  precise float3 residual = pull - force;
  precise float3 change = pull - before;
  begin.split.residual = residual;
  begin.change = change;
  begin.found = float4(asfloat(found.xyz), plane.w);
  begin.more = (found.w & kContactMore) != 0u;
  return begin;
}

// Takes the force of a record to the next iteration, dx from the iterate.
ContactSplit nextForce(ContactSplit split, float3 dx) {
  precise float3 v = penalized(split.normal, split.weight, dx) * kRelaxation +
                     split.residual * (1.0 - kRelaxation);
  precise float3 trial = split.force - split.offset - v;
  float3 next = projected(split.normal, split.friction, trial);
  precise float3 residual = v + (next - split.force);
  split.force = next;
  split.residual = residual;
  return split;
}

// Returns the sum of a change and that from one iteration to the next.
float3 addChange(float3 sum, ContactSplit before, ContactSplit after) {
  precise float3 pull = before.force + before.residual;
  precise float3 change = sum + ((after.force + after.residual) - pull);
  return change;
}

// The force of a record that the next round or step begins with.
struct KeptForce {
  float3 force;
  float size;
  float change;  // of the size
};

// Stores the force of a record.
KeptForce keepForce(uint record, uint plane, uint vertex, ExactStrand strand, ContactSplit split) {
  precise float normalForce = max(dot3(split.normal, split.force), 0.0);
  float3 tangential = tangentialPart(split.normal, split.force);
  if (!isUsable(tangential) || !(normalForce < 1e18)) {
    normalForce = 0.0;
    tangential = float3(0.0, 0.0, 0.0);
  }
  uint element = kContactElements * record;
  g_contacts[element + 2u] = asuint(float4(tangential, normalForce));
  float along = kNoLimit;
  if (normalForce > 0.0) along = dot3(split.normal, asfloat(g_contacts[element + 1u].xyz));
  storeScratch(kScratchPlanes + plane, vertex, strand, float4(split.normal, along));
  precise float3 force = split.normal * normalForce + tangential;
  precise float size = lengthOf(split.force);
  precise float change = abs(size - split.forceBefore);
  KeptForce kept;
  kept.force = force;
  kept.size = size;
  kept.change = change;
  return kept;
}

// The contacts of a vertex.
struct Touch {
  uint vertex;
  bool second;  // it has two
  ContactSplit a;
  ContactSplit b;
  float3 change;  // of the forces since the elimination
  float4 found;
  float distance;  // of the second plane
};

Touch noTouch() {
  Touch touch;
  touch.vertex = 0u;
  touch.second = false;
  touch.a = noSplit();
  touch.b = noSplit();
  touch.change = float3(0.0, 0.0, 0.0);
  touch.found = float4(0.0, 0.0, 0.0, 0.0);
  touch.distance = kNoLimit;
  return touch;
}

Touch beginTouch(uint vertex, ExactStrand strand) {
  uint record = recordOf(strand, vertex);
  TouchState state = loadState(vertex, strand);
  Begin begin = beginForce(record, state);
  Touch touch = noTouch();
  touch.vertex = vertex;
  touch.second = begin.more;
  touch.a = begin.split;
  touch.change = begin.change;
  touch.found = begin.found;
  if (begin.more) {
    begin = beginForce(record + 1u, state);
    touch.b = begin.split;
    touch.distance = begin.found.w;
    precise float3 change = touch.change + begin.change;
    touch.change = change;
  }
  return touch;
}

// Takes the forces to the next iteration, dx from the iterate.
Touch nextForces(Touch touch, float3 dx) {
  ContactSplit next = nextForce(touch.a, dx);
  float3 change = addChange(float3(0.0, 0.0, 0.0), touch.a, next);
  touch.a = next;
  if (touch.second) {
    next = nextForce(touch.b, dx);
    change = addChange(change, touch.b, next);
    touch.b = next;
  }
  precise float3 sum = touch.change + change;
  touch.change = sum;
  return touch;
}

// Stores what roll_out_strands needs. Returns the sum of the sizes of the forces, and of the changes
// of those.
float2 endTouch(Touch touch, ExactStrand strand) {
  uint record = recordOf(strand, touch.vertex);
  KeptForce kept = keepForce(record, 0u, touch.vertex, strand, touch.a);
  precise float3 force = kept.force;
  precise float load = lengthOf(kept.force);
  precise float2 sums = float2(kept.size, kept.change);
  if (touch.second) {
    kept = keepForce(record + 1u, 1u, touch.vertex, strand, touch.b);
    force = force + kept.force;
    load = load + lengthOf(kept.force);
    sums = sums + float2(kept.size, kept.change);
  }
  storeScratch(kScratchForces, touch.vertex, strand, float4(force, load));
  storeScratch(kScratchFound, touch.vertex, strand, touch.found);
  storeScratch(kScratchFound + 1u, touch.vertex, strand, float4(0.0, 0.0, 0.0, touch.distance));
  storeChange(touch.vertex, strand, touch.change);
  return sums;
}

// Returns the vertex of the `contact`-th bit of a strand's mask.
uint vertexOf(uint index, uint count, uint contact) {
  uint vertex = 0u;
  uint before = 0u;
  for (uint word = 0u; word * 32u < count; ++word) {
    uint mask = contactMask(index, word * 32u);
    uint bits = countbits(mask);
    if (contact >= before && contact < before + bits) {
      for (uint k = before; k < contact; ++k) mask = mask & (mask - 1u);
      vertex = word * 32u + firstbitlow(mask);
    }
    before = before + bits;
  }
  return vertex;
}

// Three columns of the matrix in a lane: states for unit forces.
struct Columns {
  RodState a;
  RodState b;
  RodState c;
};

void storeBlock(uint block, Columns columns) {
  s_blocksA[block] = float4(columns.a.dx, columns.b.dx.x);
  s_blocksB[block] = float4(columns.b.dx.yz, columns.c.dx.xy);
  s_blocksC[block] = columns.c.dx.z;
}

Columns noColumns() {
  Columns columns;
  columns.a = noState();
  columns.b = noState();
  columns.c = noState();
  return columns;
}

float3 axisOf(uint i) {
  return float3(i == 0u ? 1.0 : 0.0, i == 1u ? 1.0 : 0.0, i == 2u ? 1.0 : 0.0);
}

void storeProduct(uint word, RodState state) {
  s_products[word] = state.dx.x;
  s_products[word + 1u] = state.dx.y;
  s_products[word + 2u] = state.dx.z;
  s_products[word + 3u] = state.u.x;
  s_products[word + 4u] = state.u.y;
  s_products[word + 5u] = state.u.z;
}

// Returns a column of the compliance behind an edge, from the row of T C.
// \param word  the row's first one
RodState nextCompliance(uint column, uint word, Gain g, StoredResponse stored) {
  float3 e = stored.c.xyz;
  RodState row;
  row.dx = float3(s_products[word], s_products[word + 6u], s_products[word + 12u]);
  row.u = float3(s_products[word + 18u], s_products[word + 24u], s_products[word + 30u]);
  row = advance(g, float3(0.0, 0.0, 0.0), e, row);
  float3 axis = axisOf(column < 3u ? column : column - 3u);
  float3 moment = cross3(e, axis);
  float3 own = multiplySymmetric(inversePivot(stored), column < 3u ? moment : axis);
  precise float3 u = row.u + own;
  precise float3 dx = row.dx + cross3(own, e);
  row.u = u;
  row.dx = dx;
  return row;
}

// Root to the last vertex in contact: the matrix. Returns dx by the gains of the lane's vertex.
// \param furthest  of the last vertices of the group's strands
float3 fillMatrix(GroupStrand own, ExactStrand strand, uint furthest) {
  bool compliant = own.lane < kComplianceLanes;
  Columns columns = noColumns();
  RodState response = noState();  // to forces at the vertex itself; of one lane to the gains
  float3 free = float3(0.0, 0.0, 0.0);
  float3 zero = float3(0.0, 0.0, 0.0);
  uint contact = 0u;
  uint mask = 0u;
  uint products = 36u * own.number;
  uint starts = 8u * own.number;
  uint most = max(own.last, 2u) - 1u;
  PackedGain packed = loadGain(1u, strand);
  StoredResponse stored = loadResponse(1u, strand);
  [loop] for (uint i = 1u; i < furthest; ++i) {
    // Loads of the next iteration, before the arithmetic of this one.
    uint after = min(i + 1u, most);
    PackedGain packedNext = loadGain(after, strand);
    StoredResponse storedNext = loadResponse(after, strand);
    if (i == 1u || ((i + 1u) & 31u) == 0u) mask = contactMask(own.index, i + 1u);
    bool inContact = i < own.last && hasContact(mask, i + 1u);
    Gain g = unpackGain(packed);
    float3 e = stored.c.xyz;
    columns.a = advance(g, zero, e, columns.a);
    columns.b = advance(g, zero, e, columns.b);
    columns.c = advance(g, zero, e, columns.c);
    response = advance(g, own.lane == kFreeLane ? g.k : zero, e, response);
    if (compliant) storeProduct(products + 6u * own.lane, response);
    GroupMemoryBarrierWithGroupSync();
    if (compliant) response = nextCompliance(own.lane, products + own.lane, g, stored);
    if (inContact && (own.lane < 3u || own.lane == kFreeLane)) {
      uint start = starts + 2u * min(own.lane, 3u);
      s_starts[start] = response.dx;
      s_starts[start + 1u] = response.u;
    }
    GroupMemoryBarrierWithGroupSync();
    if (inContact) {
      if (own.lane == contact) {
        columns.a.dx = s_starts[starts];
        columns.a.u = s_starts[starts + 1u];
        columns.b.dx = s_starts[starts + 2u];
        columns.b.u = s_starts[starts + 3u];
        columns.c.dx = s_starts[starts + 4u];
        columns.c.u = s_starts[starts + 5u];
        free = s_starts[starts + 6u];
      }
      if (own.lane <= contact) storeBlock(blockAt(own, contact, own.lane), columns);
      contact = contact + 1u;
    }
    packed = packedNext;
    stored = storedNext;
  }
  return free;
}

// Returns dx of the lane's vertex by the change of the forces at vertex j, both in contact.
float3 responseTo(GroupStrand own, uint j) {
  uint other = min(j, own.count - 1u);
  bool below = other <= own.lane;
  uint block = blockAt(own, below ? own.lane : other, below ? other : own.lane);
  float4 a = s_blocksA[block];
  float4 b = s_blocksB[block];
  float c = s_blocksC[block];
  float3 f = j < own.count ? s_changes[own.firstLane + other].xyz : float3(0.0, 0.0, 0.0);
  // Above the diagonal the transposed block.
  float3 m0 = float3(a.x, below ? a.yz : float2(a.w, b.z));
  float3 m1 = float3(below ? a.w : a.y, b.x, below ? b.y : b.w);
  float3 m2 = float3(below ? b.zw : float2(a.z, b.y), c);
  precise float3 dx = m0 * f.x + m1 * f.y + m2 * f.z;
  return dx;
}

// Returns dx of the lane's vertex by the gains and the changes of all forces. Four at a time, which do
// not wait for each other.
float3 responseAt(GroupStrand own, float3 dx) {
  precise float3 sum = dx;
  for (uint j = 0u; j < own.count; j += 4u) {
    float3 r0 = responseTo(own, j);
    float3 r1 = responseTo(own, j + 1u);
    float3 r2 = responseTo(own, j + 2u);
    float3 r3 = responseTo(own, j + 3u);
    sum = sum + ((r0 + r1) + (r2 + r3));
  }
  return sum;
}

// ---- more vertices in contact than the matrix has

// Set of a record in the scratch, from that of the states on.
uint splitSet(uint k) { return kScratchStates + 3u * k; }

void storeSplit(uint k, uint vertex, ExactStrand strand, ContactSplit split) {
  uint set = splitSet(k);
  storeScratch(set, vertex, strand, float4(split.offset, split.forceBefore));
  storeScratch(set + 1u, vertex, strand, float4(split.force, split.weight));
  storeScratch(set + 2u, vertex, strand, float4(split.residual, 0.0));
}

ContactSplit loadSplit(uint k, uint vertex, ExactStrand strand) {
  uint set = splitSet(k);
  uint element = kContactElements * (recordOf(strand, vertex) + k);
  float4 a = loadScratch(set, vertex, strand);
  float4 b = loadScratch(set + 1u, vertex, strand);
  ContactSplit split;
  split.normal = asfloat(g_contacts[element].xyz);
  split.friction = asfloat(g_contacts[element + 1u].w);
  split.offset = a.xyz;
  split.weight = b.w;
  split.force = b.xyz;
  split.forceBefore = a.w;
  split.residual = loadScratch(set + 2u, vertex, strand).xyz;
  return split;
}

Touch loadSplits(uint vertex, ExactStrand strand) {
  uint record = recordOf(strand, vertex);
  uint4 found = g_contacts[kContactElements * record + 3u];
  Touch touch = noTouch();
  touch.vertex = vertex;
  touch.second = (found.w & kContactMore) != 0u;
  touch.a = loadSplit(0u, vertex, strand);
  touch.found = float4(asfloat(found.xyz), asfloat(g_contacts[kContactElements * record].w));
  if (touch.second) {
    touch.b = loadSplit(1u, vertex, strand);
    touch.distance = asfloat(g_contacts[kContactElements * (record + 1u)].w);
  }
  return touch;
}

void storeSplits(Touch touch, ExactStrand strand) {
  storeSplit(0u, touch.vertex, strand, touch.a);
  if (touch.second) storeSplit(1u, touch.vertex, strand, touch.b);
  storeChange(touch.vertex, strand, touch.change);
}

// Iterations by sweeps. Returns the sums of endTouch().
float2 sweepForces(ExactStrand strand, uint index, uint last) {
  uint i;
  [loop] for (i = 2u; i <= last; ++i) {
    if (hasContact(contactMask(index, i), i)) storeSplits(beginTouch(i, strand), strand);
  }
  [loop] for (uint k = 0u; k < kContactIterations; ++k) {
    addForces(strand, last);
    RodState state = noState();
    [loop] for (i = 1u; i < last; ++i) {
      Gain g = unpackGain(loadGain(i, strand));
      state = advance(g, g.k, loadScratch(2u, i, strand).xyz, state);
      if (hasContact(contactMask(index, i + 1u), i + 1u))
        storeSplits(nextForces(loadSplits(i + 1u, strand), state.dx), strand);
    }
  }
  precise float2 sums = float2(0.0, 0.0);
  [loop] for (i = 2u; i <= last; ++i) {
    if (hasContact(contactMask(index, i), i)) {
      Touch touch = loadSplits(i, strand);
      float4 b = loadScratch(1u, i - 1u, strand);
      touch.change = float3(b.zw, loadScratch(2u, i - 1u, strand).w);
      sums = sums + endTouch(touch, strand);
    }
  }
  return sums;
}

void storeSums(ExactStrand strand, float2 sums) {
  storeScratch(kScratchFound, 0u, strand, float4(sums, 0.0, 0.0));
}

static const uint kNoStrand = 0xffffffffu;

GroupStrand noStrand() {
  GroupStrand strand;
  strand.index = kNoStrand;
  strand.count = 0u;
  strand.last = 0u;
  strand.lane = 0u;
  strand.firstLane = 0u;
  strand.firstBlock = 0u;
  strand.number = 0u;
  return strand;
}

// Returns an entry of a list of eliminate_strands, and none past its end.
GroupStrand listedStrand(uint list, uint entry) {
  GroupStrand strand = noStrand();
  if (entry < g_contactWords[g_contactHead + kContactLists + list]) {
    uint word = listedWord(list, entry);
    uint extent = g_contactWords[word + 1u];
    strand.index = g_contactWords[word];
    strand.count = extent >> 16;
    strand.last = extent & 0xffffu;
  }
  return strand;
}

// The only strand of a group in the second round.
GroupStrand strandOfRound(uint group) {
  GroupStrand strand = noStrand();
  if (group >= g_contactWords[g_contactHead + kContactListed]) return strand;
  strand.index = g_contactWords[g_contactList + group] & ~kListedFar;
  uint vertices = strandAt(strand.index).count;
  strand.count = contactCount(strand.index, vertices);
  strand.last = lastContact(strand.index, vertices);
  return strand;
}

[numthreads(kLanes, 1, 1)]
void solve_contacts(uint3 groupId : SV_GroupID, uint lane : SV_GroupIndex) {
  uint group = groupId.z * kListedGroups + groupId.x;
  GroupStrand strand0 = noStrand();
  GroupStrand strand1 = noStrand();
  GroupStrand strand2 = noStrand();
  GroupStrand strand3 = noStrand();
  uint list = kContactListCount - 1u;
  if ((g_flags & kAgainFlag) != 0u) {
    strand0 = strandOfRound(group);
  } else {
    // The longest ones first.
    uint before = 0u;
    uint groups = g_contactWords[g_contactHead + kContactLists + list];
    while (list > 0u && group >= before + groups) {
      before += groups;
      list = list - 1u;
      uint strands = strandsOfGroup(list);
      groups = (g_contactWords[g_contactHead + kContactLists + list] + strands - 1u) / strands;
    }
    uint strands = strandsOfGroup(list);
    uint entry = (group - before) * strands;
    strand0 = listedStrand(list, entry);
    if (strands > 1u) strand1 = listedStrand(list, entry + 1u);
    if (strands > 2u) strand2 = listedStrand(list, entry + 2u);
    if (strands > 3u) strand3 = listedStrand(list, entry + 3u);
  }
  uint furthest = max(max(strand0.last, strand1.last), max(strand2.last, strand3.last));
  if (furthest < 2u) return;
  if (strand0.count > kMatrixContacts) {
    if (lane == 0u) {
      ExactStrand strand = strandAt(strand0.index);
      storeSums(strand, sweepForces(strand, strand0.index, strand0.last));
    }
    return;
  }
  uint lanes = kLanes / strandsOfGroup(list);
  uint number = lane / lanes;
  GroupStrand own = strand0;
  if (number == 1u) own = strand1;
  if (number == 2u) own = strand2;
  if (number == 3u) own = strand3;
  // A strand that is not there does as the first one, and stores nothing.
  if (own.index == kNoStrand) own.index = strand0.index;
  own.lane = lane - number * lanes;
  own.firstLane = number * lanes;
  own.firstBlock = number * (lanes * (lanes + 1u) / 2u);
  own.number = number;
  ExactStrand strand = strandAt(own.index);
  bool active = own.lane < own.count;
  float3 dx = fillMatrix(own, strand, furthest);
  Touch touch = noTouch();
  if (active) touch = beginTouch(vertexOf(own.index, strand.count, own.lane), strand);
  [loop] for (uint k = 0u; k < kContactIterations; ++k) {
    if (active) s_changes[lane] = float4(touch.change, 0.0);
    GroupMemoryBarrierWithGroupSync();
    if (active) touch = nextForces(touch, responseAt(own, dx));
    GroupMemoryBarrierWithGroupSync();
  }
  if (active) s_sums[lane] = endTouch(touch, strand);
  GroupMemoryBarrierWithGroupSync();
  if (!active || own.lane != 0u) return;
  precise float2 sums = float2(0.0, 0.0);
  for (uint j = 0u; j < own.count; ++j) sums = sums + s_sums[own.firstLane + j];
  storeSums(strand, sums);
}
