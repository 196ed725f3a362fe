// A sub-step of one strand in the exact solver, of which simulate_exact makes the whole step where
// there are no colliders; with CONTACTS, eliminate_strands and roll_out_strands make a half each.
//
// Speed: a strand is one thread, so the time depends first on the latency of a vertex through its
// loops, and with many strands on the bytes: 6 vectors are read and 6 written to the root, 7 read
// and 4 written to the tip. Loads are one iteration ahead. Square roots of numbers near 1 are short
// polynomials.
//
// Rounding: displacements are summed along the strand from the differences of tangents. A
// difference of positions that were summed in two orders is off by 1e-7 m, which the weights of
// 1e4/s2 make into a steady force.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_STEP_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_STEP_HLSLI

#include "../../base/dispatch.hlsli"
#include "../../base/random_hash.hlsli"
#include "exact_elimination.hlsli"

// Spring to the bind-pose target of a held vertex [1/s2]; with 1e8 two passes do not converge.
static const float kHoldStiffness = 1e6;
static const uint kPassLimit = 2;

// Data of a vertex in memory.
struct StoredVertex {
  float4 displacement;
  float4 displacementBefore;
  float4 displacementEarlier;
  float4 rest;
#if GLOBAL_SHAPE
  float4 bindTarget;
#endif
#if FORCES
  float4 force;
#endif
  float4 factors;
};

StoredVertex loadVertex(uint vertex, ExactStrand strand, Slots slots) {
  StoredVertex stored;
  stored.displacement = g_state[stateIndex(kDisplacementSets + slots.now, vertex, strand)];
  stored.displacementBefore = g_state[stateIndex(kDisplacementSets + slots.before, vertex, strand)];
  stored.displacementEarlier =
      g_state[stateIndex(kDisplacementSets + slots.earlier, vertex, strand)];
  stored.rest = g_rest[stateIndex(0, vertex, strand)];
#if GLOBAL_SHAPE
  stored.bindTarget = g_rest[stateIndex(1, vertex, strand)];
#endif
#if FORCES
  stored.force = g_forces[strand.target + vertex];
#endif
  stored.factors = float4(1.0, 1.0, 1.0, 0.0);
  if (g_parameterSet > 0) stored.factors = g_rest[stateIndex(g_parameterSet, vertex, strand)];
  return stored;
}

struct StoredEdge {
  float4 now;
  float4 next;  // after the first pass
};

StoredEdge loadEdge(uint edge, ExactStrand strand, Slots slots, uint pass) {
  StoredEdge stored;
  stored.now = g_state[stateIndex(kFrameSets + slots.now, edge, strand)];
  stored.next = stored.now;
  if (pass > 0) stored.next = g_state[stateIndex(kFrameSets + slots.next, edge, strand)];
  return stored;
}

// Returns a free edge in a pass.
// \param relativeRotation predicted rotation: w of the displacement of the vertex at its end
RodEdge freeEdge(StoredEdge stored, float relativeRotation, Transport transport, float edgeLength,
                 uint pass) {
  RodEdge edge;
  edge.frame = transportFrame(transport, stored.now);
  edge.halfRotation = halfRotationOn(relativeRotation, g_rotationRatio);
  edge.guess = guessFrame(edge.frame, edge.halfRotation);
  edge.iterate = edge.guess;
  if (pass > 0) edge.iterate = stored.next;
  edge.edgeLength = edgeLength;
  return edge;
}

// Returns edge 0.
RodEdge rootEdge(StoredEdge stored, Transport transport, float4 frame) {
  RodEdge edge;
  edge.frame = transportFrame(transport, stored.now);
  edge.halfRotation = float3(0.0, 0.0, 0.0);
  edge.guess = frame;
  edge.iterate = frame;
  edge.edgeLength = 0.0;
  return edge;
}

// Contribution of an acceleration a and a drag k to the equation of a free vertex.
struct ExtraForce {
  float3 acceleration;  // [m/s2]
  float drag;           // [1/s]; below 0 it takes from the air's
};

ExtraForce extraForce(StoredVertex stored) {
  precise float drag = 0.0;
  precise float3 acceleration = float3(0.0, 0.0, 0.0);
  if (g_parameterSet > 0) {
    drag = g_air.w * (stored.factors.z - 1.0);
    acceleration = g_air.xyz * drag;
  }
#if FORCES
  if (isUsable(stored.force)) {
    drag = drag + max(stored.force.w, 0.0);
    acceleration = acceleration + stored.force.xyz * (1.0 - g_drift.w);
  }
#endif
  ExtraForce extra;
  extra.acceleration = acceleration;
  extra.drag = drag;
  return extra;
}

// Returns the displacement in a step by gravity and wind. Every strand has its own phase of the
// gusts.
float3 strandDrift(ExactStrand strand) {
  float3 drift = g_drift.xyz;
  if (g_gust0.w > 0.0) {
    precise float a = 2.0 * unitFloat(hashUint(strand.seed)) - 1.0;
    precise float b = 2.0 * unitFloat(hashUint(strand.seed + 1u)) - 1.0;
    float inverse = inverseRoot(max(a * a + b * b, 1e-12));
    precise float s0 = g_gust0.w * (a * inverse - 1.0);
    precise float s1 = g_gust0.w * (b * inverse);
    precise float3 varied = drift + g_gust0.xyz * s0 + g_gust1.xyz * s1;
    drift = varied;
  }
  return drift;
}

// Returns the displacement to which the last three displacements of a vertex lead.
float3 freeDisplacement(StoredVertex stored, Transport transport) {
  return transportedDisplacements(transport, stored.displacement.xyz, stored.displacementBefore.xyz,
                                  stored.displacementEarlier.xyz);
}

// \param displacements where the vertex goes without a force
RodTarget targetOf(StoredVertex stored, Transport transport, RodRoot root, float3 drift,
                   float3 displacements) {
  precise float3 target = displacements + drift;
  precise float weight = g_weight;
#if FORCES
  bool forced = true;
#else
  bool forced = g_parameterSet > 0;
#endif
  if (forced) {
    ExtraForce extra = extraForce(stored);
    precise float heavier = weight + extra.drag * g_inverseStep;
    precise float share = weight / heavier;
    // xb - x of BDF2, without drag.
    precise float3 back =
        transportDisplacement(transport, stored.displacement.xyz) * -g_historyShare;
    precise float3 pushed = back + (target - back) * share + extra.acceleration / heavier;
    target = pushed;
    weight = heavier;
  }
  RodTarget free = noTarget();
  free.displacement = target;
#if GLOBAL_SHAPE
  float spring = kHoldStiffness;
  if (stored.bindTarget.w >= 0.0) {
    precise float fade = 0.25 * g_targetRange;
    precise float within = (g_targetRange + fade - stored.bindTarget.w) / fade;
    precise float faded = g_targetStiffness * stored.factors.y * min(max(within, 0.0), 1.0);
    spring = faded;
  }
  if (spring > 0.0) {
    precise float3 bindTarget = root.position + rotate(root.rotation, stored.bindTarget.xyz);
    weight = weight + spring;
    precise float bindShare = spring / weight;
    free.bindTarget = bindTarget;
    free.share = bindShare;
  }
#endif
  precise float am = stored.rest.w * weight;
  free.weight = am;
  return free;
}

// Writes the bind shape at the root's pose, at rest, into the states from which the step starts.
void resetStrand(ExactStrand strand, Slots slots, RodRoot root, uint index) {
  uint tip = strand.count - 1;
  float4 rootRest = g_rest[stateIndex(0, 0, strand)];
  float4 frame = normalizeProduct(multiplyQuaternions(root.rotation, rootRest));
  float edgeLength = g_rest[stateIndex(0, tip, strand)].x;
  precise float3 x = root.position + axisX(frame) * edgeLength;
  float4 zero = float4(0.0, 0.0, 0.0, 0.0);
  float4 identity = float4(0.0, 0.0, 0.0, 1.0);
  g_state[strandIndex(kFirstPosition, slots.now, index)] = float4(x, 0.0);
  bool shown = (g_flags & kPoseFlag) != 0u;
  for (uint i = 0; i < strand.count; ++i) {
    precise float3 world = (i == 0 ? root.position : x) + g_origin.xyz;
    if (shown) g_positions[strand.target + i] = float4(world, i < 2 ? 0.0 : 1.0);
    if (i == tip) {
      frame = identity;
    } else if (i > 0) {
      frame = normalizeProduct(multiplyQuaternions(frame, bindRotation(i, strand)));
      x = x + axisX(frame) * g_rest[stateIndex(0, i, strand)].z;
    }
    g_state[stateIndex(kDisplacementSets + slots.now, i, strand)] = zero;
    g_state[stateIndex(kDisplacementSets + slots.before, i, strand)] = zero;
    g_state[stateIndex(kDisplacementSets + slots.earlier, i, strand)] = zero;
    g_state[stateIndex(kFrameSets + slots.now, i, strand)] = frame;
  }
  g_state[strandIndex(kGuessedDisplacement, slots.now, index)] = zero;
  g_state[strandIndex(kTipPosition, slots.now, index)] = float4(x, 0.0);
  g_state[strandIndex(kRootVelocity, slots.now, index)] = zero;
  g_state[strandIndex(kTransportRotation, slots.now, index)] = identity;
  g_state[strandIndex(kTransportRotation, slots.before, index)] = identity;
}

// Moves the state now to the new origin.
void rebaseStrand(Slots slots, uint index) {
  uint first = strandIndex(kFirstPosition, slots.now, index);
  uint tip = strandIndex(kTipPosition, slots.now, index);
  precise float3 movedFirst = g_state[first].xyz + g_rebase.xyz;
  precise float3 movedTip = g_state[tip].xyz + g_rebase.xyz;
  g_state[first] = float4(movedFirst, 0.0);
  g_state[tip] = float4(movedTip, 0.0);
}

// Position and tangent for drawing. A vertex's tangent is the direction from the previous to the
// next vertex; at the two ends, that of the only edge.
void writeOutput(uint vertex, ExactStrand strand, float3 x, float3 across, float3 fallback) {
  precise float3 world = x + g_origin.xyz;
  g_positions[strand.target + vertex] = float4(world, vertex < 2 ? 0.0 : 1.0);
  g_tangents[strand.target + vertex] = float4(directionOr(across, fallback), 0.0);
}

// Returns the rotation of an edge by its control law, made finite and at most kStepLimit; w = its
// square before the limit.
float4 limitedRotation(float3 u) {
  precise float size = abs(u.x) + abs(u.y) + abs(u.z);
  precise float3 relativeRotation = u;
  // On the bits, because a driver may assume that no float is a NaN: below 1e30.
  if (asuint(size) >= 0x7149f2cau) {
    relativeRotation = float3(0.0, 0.0, 0.0);
  } else if (size > 4.0) {
    // Limited before it is squared: the square of a huge rotation would not be finite.
    precise float factor = 4.0 / size;
    relativeRotation = relativeRotation * factor;
  }
  precise float squared = dot3(relativeRotation, relativeRotation);
  if (squared > kStepLimit * kStepLimit) {
    precise float factor = kStepLimit * inverseRoot(squared);
    relativeRotation = relativeRotation * factor;
  }
  return float4(relativeRotation, squared);
}

// Where the tip is in an iterate.
struct TipState {
  float3 displacement;  // relative to vertex 1
  float3 x;
};

// A strand in this sub-step.
struct RodStep {
  ExactStrand strand;
  uint index;  // of the strand
  Slots slots;
  Transport transport;
  float4 transported;           // rotation of the transport
  RodRoot root;                 // at the end of the sub-step
  float3 rootVelocity;          // in this frame [m/s]
  float4 rootFrame;             // of edge 0
  float3 edge0;                 // vector of edge 0 [m]
  float3 x1;                    // position of vertex 1
  float3 rootStepDisplacement;  // of vertex 1 [m]
  float3 drift;
  bool overlaps;  // a vertex has a contact
};

// Returns the index of a strand whose tile is in the list of those awake, of thread `index` of
// them; kNoStrand past the end.
static const uint kNoStrand = 0xffffffffu;
uint awakeStrand(uint index) {
  uint entry = index / kTileStrands;
  if (entry >= tileCount()) return kNoStrand;
  return g_sleep[kSleepHead + entry] * kTileStrands + index % kTileStrands;
}

#if CONTACTS
// Returns the strand of a thread, and kNoStrand if it has none.
uint strandOfLane(uint3 group, uint lane) {
  if ((g_flags & kAgainFlag) != 0u) {
    uint entry = (group.z * kListedGroups + group.x) * kAgainStrands + lane;
    if (lane >= kAgainStrands) return kNoStrand;
    if (entry >= g_contactWords[g_contactHead + kContactListed]) return kNoStrand;
    return g_contactWords[g_contactList + entry] & ~kListedFar;
  }
  uint strands = (g_flags & kNarrowFlag) != 0u ? kNarrowStrands : kTileStrands;
  if (lane >= strands) return kNoStrand;
  // The list has tiles: x is the tile and y its part.
  if ((g_flags & kSleepFlag) != 0u)
    return g_sleep[kSleepHead + group.x] * kTileStrands + group.y * strands + lane;
  return indexOfGroup(group) * strands + lane;
}

// Adds a group to an indirect dispatch.
void listGroup(uint arguments, uint group) {
  uint word = g_contactHead + arguments;
  InterlockedMax(g_contactWords[word], min(group + 1u, kListedGroups));
  InterlockedMax(g_contactWords[word + 2u], group / kListedGroups + 1u);
}
#endif

// Returns false for a strand that is not simulated, or does not fit its buffers.
bool isSimulated(uint index) {
  if (index >= min(g_strandCount, g_simulatedCount)) return false;
  ExactStrand strand = strandAt(index);
  return isSound(strand) && fitsOutputs(strand);
}

RodStep beginStep(uint index) {
  RodStep rod;
  rod.strand = strandAt(index);
  rod.index = index;
  rod.slots = slotsOfTile(index / kTileStrands);
  RootPath path = rootPath(rod.strand.root);
  rod.root = rootAt(path, g_rootEnd);
  precise float3 rootVelocity = (path.to.position - path.from.position) / g_frameTime;
  rod.rootVelocity = rootVelocity;
  RigidMotion transported = noMotion();
#if VELOCITY_SHOCK_PROPAGATION
  if ((g_flags & kResetFlag) == 0u) {
    float3 before = g_state[strandIndex(kRootVelocity, rod.slots.now, index)].xyz;
    precise float3 change = rootVelocity - before;
    precise float between = 0.5 * (g_frameTime + g_frameTimeBefore);
    precise float acceleration = squareRoot(dot3(change, change)) / between;
    precise float excess = min(max(acceleration / g_vspThreshold - 1.0, 0.0), 1.0);
    precise float share = g_vspCoefficient + (1.0 - g_vspCoefficient) * excess;
    transported = transportedMotion(rootAt(path, g_rootBegin), rod.root, share);
  }
  rod.transport =
      transportOf(transported, g_state[strandIndex(kTransportRotation, rod.slots.now, index)],
                  g_state[strandIndex(kTransportRotation, rod.slots.before, index)]);
#else
  rod.transport.unused = 0;
#endif
  rod.transported = transported.rotation;
  float4 rootRest = g_rest[stateIndex(0, 0, rod.strand)];
  rod.rootFrame = normalizeProduct(multiplyQuaternions(rod.root.rotation, rootRest));
  precise float3 edge0 =
      axisX(rod.rootFrame) * g_rest[stateIndex(0, rod.strand.count - 1u, rod.strand)].x;
  precise float3 x1 = rod.root.position + edge0;
  float3 oldX1 =
      transportPoint(rod.transport, g_state[strandIndex(kFirstPosition, rod.slots.now, index)].xyz);
  precise float3 rootStepDisplacement = x1 - oldX1;
  rod.edge0 = edge0;
  rod.x1 = x1;
  rod.rootStepDisplacement = rootStepDisplacement;
  rod.drift = strandDrift(rod.strand);
  rod.overlaps = false;
#if CONTACTS
  rod.overlaps = touchesAnything(index, rod.strand.count);
#endif
  return rod;
}

#if CONTACTS
// Returns where a vertex in contact goes on to, without a rebound: BDF2 extrapolates the last change
// of the displacement, which after an impact would be a rebound with two thirds of the speed. Along
// the normals of contacts that pressed, the vertex goes on outward no faster than it moved, or than
// the surface does.
//
// \param displacements where the last three displacements lead, and the drift
// \param last          the last displacement
float3 limitRebound(float3 displacements, float3 last, Transport transport, StoredTouch touch) {
  precise float share =
      g_displacementShare + g_displacementShareBefore + g_displacementShareEarlier;
  precise float3 steady = transportDisplacement(transport, last) * share;
  float3 n = touch.plane0.xyz;
  precise float most = max(dot3(n, steady), touch.plane0.w);
  precise float3 limited = displacements - n * max(dot3(n, displacements) - most, 0.0);
  n = touch.plane1.xyz;
  most = max(dot3(n, steady), touch.plane1.w);
  limited = limited - n * max(dot3(n, limited) - most, 0.0);
  return limited;
}

// Stores what solve_contacts needs of a vertex in contact.
void storeState(ExactStrand strand, uint index, RodVertex vertex) {
  precise float3 free = vertex.target - vertex.displacement;
  storeScratch(kScratchStates, index, strand, float4(vertex.x, vertex.weight));
  storeScratch(kScratchStates + 1u, index, strand, float4(vertex.displacement, 0.0));
  storeScratch(kScratchStates + 2u, index, strand, float4(free, 0.0));
}
#endif

// The records of a vertex in the elimination.
struct JointContact {
  bool inContact;
#if CONTACTS
  StoredTouch touch;
#endif
};

// Returns an edge and the vertex at its root's end.
RodJoint jointOf(RodStep rod, StoredVertex stored, RodEdge edge, RodEdge parent, uint pass,
                 JointContact contact) {
  RodJoint joint;
  float3 rotated = float3(0.0, 0.0, 0.0);
  if (pass > 0) rotated = rotationBetween(edge.iterate, edge.guess);
  joint.tangent = axisX(edge.iterate);
  joint.edgeLength = edge.edgeLength;
  joint.halfRotation = edge.halfRotation;
  joint.rotated = dot3(joint.tangent, rotated);
  precise float3 moved = (joint.tangent - axisX(edge.frame)) * edge.edgeLength;
  joint.moved = moved;
  // Stiffness is divided by the Voronoi length.
  precise float inverseVoronoiLength = max(stored.factors.x, 1e-6) / stored.rest.w;
  joint.bending = bendingOf(edge, parent, restRotation(stored.rest.xy), inverseVoronoiLength);
  precise float twistStiffness = g_twistStiffness * inverseVoronoiLength;
  joint.twistStiffness = twistStiffness;
  float3 displacements = freeDisplacement(stored, rod.transport);
#if CONTACTS
  if (contact.inContact)
    displacements =
        limitRebound(displacements, stored.displacement.xyz, rod.transport, contact.touch);
#endif
  joint.target = targetOf(stored, rod.transport, rod.root, rod.drift, displacements);
  return joint;
}

// A strand between two edges of its elimination: the vertex at their joint, and all behind it.
struct RodChain {
  Value value;
  float weight;  // am of the vertex
  float3 displacement;
  float3 x;
};

// Returns the tip.
// \param stores  false: of several lanes one stores what solve_contacts needs
RodChain beginChain(RodStep rod, TipState tip, StoredVertex stored, JointContact contact,
                    bool stores) {
  uint end = rod.strand.count - 1u;
  precise float3 displacement = tip.displacement + rod.rootStepDisplacement;
  float3 displacements = freeDisplacement(stored, rod.transport);
#if CONTACTS
  if (contact.inContact)
    displacements =
        limitRebound(displacements, stored.displacement.xyz, rod.transport, contact.touch);
#endif
  RodTarget target = targetOf(stored, rod.transport, rod.root, rod.drift, displacements);
  RodVertex vertex = vertexAt(target, tip.x, displacement);
  RodChain chain;
  chain.value = addVertex(emptyValue(), vertex);
  chain.weight = vertex.weight;
  chain.displacement = displacement;
  chain.x = tip.x;
#if CONTACTS
  if (!rod.overlaps) chain.value.load = 1e30;
  if (contact.inContact) {
    chain.value = addContacts(chain.value, rod.strand, contact.touch, vertex);
    if (stores) storeState(rod.strand, end, vertex);
  }
#endif
  return chain;
}

// Eliminates edge i, and adds vertex i.
RodChain eliminateJoint(RodChain chain, RodStep rod, uint i, RodJoint joint, JointContact contact) {
  precise float3 displacement = chain.displacement - joint.moved;
  precise float3 x = chain.x - joint.tangent * joint.edgeLength;
  Elimination step = eliminateEdge(chain.value, joint, chain.weight);
  storeGain(i, rod.strand, step.gain);
  RodChain next;
  next.value = step.value;
#if CONTACTS
  if (rod.overlaps) storeResponse(i, rod.strand, step.response);
#endif
  RodVertex vertex = vertexAt(joint.target, x, displacement);
  if (i > 1) {
    next.value = addVertex(next.value, vertex);
#if CONTACTS
    if (contact.inContact) {
      next.value = addContacts(next.value, rod.strand, contact.touch, vertex);
      storeState(rod.strand, i, vertex);
    }
#endif
  }
  next.weight = vertex.weight;
  next.displacement = displacement;
  next.x = x;
  return next;
}

// Tip to root.
void eliminate(RodStep rod, uint pass, TipState tip) {
  ExactStrand strand = rod.strand;
  Slots slots = rod.slots;
  Transport transport = rod.transport;
  uint last = strand.count - 2;  // edge
  StoredVertex storedEnd = loadVertex(last + 1, strand, slots);
  StoredVertex stored = loadVertex(last, strand, slots);
  StoredEdge storedEdge = loadEdge(last, strand, slots, pass);
  StoredEdge storedParent = loadEdge(last - 1, strand, slots, pass);
  JointContact contact;
  contact.inContact = false;
#if CONTACTS
  uint mask = 0u;
  if (rod.overlaps) mask = contactMask(rod.index, last + 1);
  contact.inContact = hasContact(mask, last + 1);
  contact.touch = loadTouch(last + 1, strand, kScratchForces);
#endif
  RodChain chain = beginChain(rod, tip, storedEnd, contact, true);
  RodEdge edge = freeEdge(storedEdge, storedEnd.displacement.w, transport, stored.rest.z, pass);
  [loop] for (uint i = last; i >= 1; --i) {
    // Loads of the next iteration, before the arithmetic of this one.
    StoredVertex storedNext = loadVertex(i - 1, strand, slots);
    StoredEdge storedGrandparent = loadEdge(i > 1 ? i - 2 : 0, strand, slots, pass);
#if CONTACTS
    if (rod.overlaps && (i & 31u) == 31u) mask = contactMask(rod.index, i);
    contact.inContact = i > 1 && hasContact(mask, i);
    if (contact.inContact) contact.touch = loadTouch(i, strand, kScratchForces);
#endif

    RodEdge parent = rootEdge(storedParent, transport, rod.rootFrame);
    if (i > 1)
      parent = freeEdge(storedParent, stored.displacement.w, transport, storedNext.rest.z, pass);
    RodJoint joint = jointOf(rod, stored, edge, parent, pass, contact);
    chain = eliminateJoint(chain, rod, i, joint, contact);

    stored = storedNext;
    storedParent = storedGrandparent;
    edge = parent;
  }
}

struct RollOut {
  float largest;               // square of the largest rotation [rad^2]
  float farthest;              // square of the largest displacement [m2]
  TipState tip;                // in the new iterate
  float3 guessedDisplacement;  // of the tip in the next step's guess, against the new positions
#if CONTACTS
  bool far;  // a vertex is far from where its contact was found
#endif
};

// An edge before its rotation.
struct RolledEdge {
  float4 old;  // before the step, transported
  float4 iterate;
  float3 halfRotation;
  float edgeLength;
};

RolledEdge rolledEdge(StoredEdge stored, float3 halfRotation, float edgeLength, Transport transport,
                      uint pass) {
  RolledEdge edge;
  edge.old = transportFrame(transport, stored.now);
  edge.iterate = stored.next;
  if (pass == 0) edge.iterate = guessFrame(edge.old, halfRotation);
  edge.halfRotation = halfRotation;
  edge.edgeLength = edgeLength;
  return edge;
}

// A strand in its roll-out, up to the start of an edge.
struct RollChain {
  float3 x;
  float3 displacement;
  float3 dx;  // of the solution against the iterate
  float3 u;
  float4 frame;
  float3 edge;    // its vector
  float3 offset;  // from the solution
  float largest;
  float farthest;
};

RollChain beginRollOut(RodStep rod) {
  RollChain chain;
  chain.x = rod.x1;
  chain.displacement = float3(0.0, 0.0, 0.0);
  chain.dx = float3(0.0, 0.0, 0.0);
  chain.u = float3(0.0, 0.0, 0.0);
  chain.frame = rod.rootFrame;
  chain.edge = rod.edge0;
  chain.offset = float3(0.0, 0.0, 0.0);
  chain.largest = 0.0;
  chain.farthest = 0.0;
  return chain;
}

// Rotates an edge by its control law.
//
// \param oldTangent  before the step, transported
RollChain rollEdge(RollChain chain, RodStep rod, Gain g, float4 iterate, float3 oldTangent,
                   JointContact contact) {
  RollChain next = chain;
  float4 limited = limitedRotation(controlLaw(g, g.k, chain.u, chain.dx));
  next.u = limited.xyz;
  next.largest = max(chain.largest, limited.w);
  float4 frame = rotatedBy(next.u, iterate);
#if CONTACTS
  if (rod.overlaps) {
    // To the solution, and in front of the planes.
    float3 led = axisX(frame);
    float3 direction = led;
    precise float3 offset = chain.offset;
    if (dot3(offset, offset) > 1e-18) {
      precise float3 arm = led * g.edgeLength - offset;
      precise float squared = dot3(arm, arm);
      precise float least = 1e-6 * g.edgeLength * g.edgeLength;
      if (squared > least) direction = directionOr(arm, led);
    }
    if (contact.inContact) {
      StoredTouch touch = contact.touch;
      direction =
          keepOut(direction, touch.plane0.xyz, touch.a.xyz, touch.a.w, chain.x, g.edgeLength);
      direction =
          keepOut(direction, touch.plane1.xyz, touch.a.xyz, touch.b.w, chain.x, g.edgeLength);
    }
    if (direction.x != led.x || direction.y != led.y || direction.z != led.z) {
      frame = rotateFrame(frame, led, direction);
      offset = offset + (axisX(frame) - led) * g.edgeLength;
    }
    next.offset = offset;
  }
#endif
  // A state that was not a number: the edge continues the previous one.
  if (!isUnit(frame)) frame = chain.frame;
  next.frame = frame;
  float3 tangent = axisX(frame);
  precise float3 edgeVector = tangent * g.edgeLength;
  precise float3 x = chain.x + edgeVector;
  precise float3 dx = chain.dx;
#if CONTACTS
  if (rod.overlaps) dx = dx + rotatedEdge(next.u, axisX(iterate) * g.edgeLength);
  if (!rod.overlaps) dx = dx + (tangent - axisX(iterate)) * g.edgeLength;
#else
  dx = dx + (tangent - axisX(iterate)) * g.edgeLength;
#endif
  precise float3 displacement = chain.displacement + (tangent - oldTangent) * g.edgeLength;
  precise float3 wholeDisplacement = rod.rootStepDisplacement + displacement;
  next.farthest = max(chain.farthest, dot3(wholeDisplacement, wholeDisplacement));
  next.edge = edgeVector;
  next.x = x;
  next.dx = dx;
  next.displacement = displacement;
  return next;
}

struct EdgeEnd {
  float3 guessed;  // displacement of its end in the next step's guess, against its start
  bool far;        // from where its contact was found
};

// Writes edge i, the vertex at its start for drawing, and the displacement of that at its end.
//
// \param rolled  the frame of the edge, and the displacement and offset at its end
// \param start   its position
// \param across  from the vertex before to the one behind
EdgeEnd endEdge(RodStep rod, uint i, RolledEdge edge, RollChain rolled, float3 start, float3 across,
                JointContact contact) {
  float4 frame = rolled.frame;
  uint next = rod.slots.next;
  g_state[stateIndex(kFrameSets + next, i, rod.strand)] = frame;
  float3 tangent = axisX(frame);
  writeOutput(i, rod.strand, start, across, tangent);
  precise float3 x = start + tangent * edge.edgeLength;
  precise float3 wholeDisplacement = rod.rootStepDisplacement + rolled.displacement;
  float nextRotation =
      nextHalfRotation(frame, edge.old, edge.halfRotation, g_guessTrend, g_slowRotation);
  EdgeEnd end;
  end.far = false;
#if CONTACTS
  precise float3 correction = rolled.offset;
  if (contact.inContact) {
    StoredTouch touch = contact.touch;
    float3 moved = worldDisplacement(rod.transport.now, x, wholeDisplacement);
    precise float3 off = x - touch.a.xyz;
    precise float squared = dot3(off, off);
    end.far = isFar(touch.plane0, squared) || isFar(touch.plane1, squared);
    precise float gap = touch.a.w + dot3(touch.plane0.xyz, off);
    correction = correctionOf(correction, touch.plane0, gap, moved);
    gap = touch.b.w + dot3(touch.plane1.xyz, off);
    correction = correctionOf(correction, touch.plane1, gap, moved);
  }
  wholeDisplacement = wholeDisplacement - correction;
#endif
  g_state[stateIndex(kDisplacementSets + next, i + 1, rod.strand)] =
      float4(wholeDisplacement, nextRotation);
  float4 goingOn = guessFrame(frame, halfRotationOn(nextRotation, 1.0));
  precise float3 guessed = (axisX(goingOn) - tangent) * edge.edgeLength;
  end.guessed = guessed;
  return end;
}

RollOut endRollOut(RodStep rod, RollChain chain, float3 guessed) {
  writeOutput(rod.strand.count - 1u, rod.strand, chain.x, chain.edge, axisX(chain.frame));
  RollOut result;
  result.largest = chain.largest;
  result.farthest = chain.farthest;
  result.tip.displacement = chain.displacement;
  result.tip.x = chain.x;
  result.guessedDisplacement = guessed;
#if CONTACTS
  result.far = false;
#endif
  return result;
}

// Root to tip.
RollOut rollOut(RodStep rod, uint pass) {
  ExactStrand strand = rod.strand;
  Slots slots = rod.slots;
  uint last = strand.count - 2;  // edge
  writeOutput(0, strand, rod.root.position, rod.edge0, axisX(rod.rootFrame));
  RollChain chain = beginRollOut(rod);
  precise float3 guessed = float3(0.0, 0.0, 0.0);
  bool far = false;
  JointContact contact;
  contact.inContact = false;
#if CONTACTS
  uint mask = 0u;
  if (rod.overlaps) mask = contactMask(rod.index, 0);
  StoredTouch touchNext = loadTouch(2, strand, kScratchFound);
#endif
  StoredEdge stored = loadEdge(1, strand, slots, pass);
  PackedGain packed = loadGain(1, strand);
  [loop] for (uint i = 1; i <= last; ++i) {
    // Loads of the next iteration, before the arithmetic of this one.
    uint after = min(i + 1, last);
    StoredEdge storedNext = loadEdge(after, strand, slots, pass);
    PackedGain packedNext = loadGain(after, strand);
#if CONTACTS
    if (rod.overlaps && ((i + 1) & 31u) == 0u) mask = contactMask(rod.index, i + 1);
    contact.inContact = hasContact(mask, i + 1);
    contact.touch = touchNext;
    if (rod.overlaps) touchNext = loadTouch(after + 1u, strand, kScratchFound);
#endif

    Gain g = unpackGain(packed);
    RolledEdge edge = rolledEdge(stored, g.halfRotation, g.edgeLength, rod.transport, pass);
    RollChain next = rollEdge(chain, rod, g, edge.iterate, axisX(edge.old), contact);
    precise float3 across = chain.edge + next.edge;
    EdgeEnd end = endEdge(rod, i, edge, next, chain.x, across, contact);
    guessed = guessed + end.guessed;
    far = far || end.far;
    chain = next;
    stored = storedNext;
    packed = packedNext;
  }
  RollOut result = endRollOut(rod, chain, guessed);
#if CONTACTS
  result.far = far;
#endif
  return result;
}

// Returns the displacement of the tip relative to vertex 1 in the guess.
float3 guessedTipDisplacement(RodStep rod) {
  ExactStrand strand = rod.strand;
  precise float3 displacement = float3(0.0, 0.0, 0.0);
  [loop] for (uint i = 1; i + 1 < strand.count; ++i) {
    StoredEdge stored = loadEdge(i, strand, rod.slots, 0);
    float relativeRotation =
        g_state[stateIndex(kDisplacementSets + rod.slots.now, i + 1, strand)].w;
    RodEdge edge =
        freeEdge(stored, relativeRotation, rod.transport, g_rest[stateIndex(0, i, strand)].z, 0);
    displacement = displacement + (axisX(edge.iterate) - axisX(edge.frame)) * edge.edgeLength;
  }
  return displacement;
}

// Returns where the tip is in the first iterate.
TipState guessedTip(RodStep rod) {
  float3 oldTip = transportPoint(rod.transport,
                                 g_state[strandIndex(kTipPosition, rod.slots.now, rod.index)].xyz);
  precise float3 displacement = transportDisplacement(
      rod.transport, g_state[strandIndex(kGuessedDisplacement, rod.slots.now, rod.index)].xyz);
  if ((g_flags & (kChangedFlag | kResetFlag)) != 0u) displacement = guessedTipDisplacement(rod);
  precise float3 x = oldTip + (displacement + rod.rootStepDisplacement);
  TipState tip;
  tip.displacement = displacement;
  tip.x = x;
  return tip;
}

// A strand of two vertices goes with its root.
RollOut rootAlone(RodStep rod) {
  RollOut result;
  result.largest = 0.0;
  result.farthest = 0.0;
  result.tip.displacement = float3(0.0, 0.0, 0.0);
  result.tip.x = rod.x1;
  result.guessedDisplacement = float3(0.0, 0.0, 0.0);
#if CONTACTS
  result.far = false;
#endif
  float3 tangent = axisX(rod.rootFrame);
  writeOutput(0, rod.strand, rod.root.position, rod.edge0, tangent);
  writeOutput(1, rod.strand, rod.x1, rod.edge0, tangent);
  return result;
}

// Writes what the next step and the passes after the solver need of the whole strand.
// \param added  to its time at rest [s]
void endStep(RodStep rod, RollOut rolled, float added) {
  ExactStrand strand = rod.strand;
  uint tipTarget = strand.target + strand.count - 1u;
  for (uint pad = strand.count; pad < g_outputVertices; ++pad) {
    g_positions[strand.target + pad] = g_positions[tipTarget];
    g_tangents[strand.target + pad] = g_tangents[tipTarget];
  }
  bool lastSubStep = (g_flags & kLastFlag) != 0u;
  if ((g_flags & kSleepFlag) != 0u && lastSubStep) {
    uint word = kSleepHead + 2 * tileCount() + rod.index;
    precise float rested = asfloat(g_sleep[word]) + added;
    // Negated, so that a NaN counts as motion.
    precise float restDisplacement = g_restSpeed * (g_frameTime * (g_rootEnd - g_rootBegin));
    if (!(rolled.farthest < restDisplacement * restDisplacement)) rested = 0.0;
    g_sleep[word] = asuint(rested);
  }
  float3 rootVelocity = rod.rootVelocity;
  if (!lastSubStep)
    rootVelocity = g_state[strandIndex(kRootVelocity, rod.slots.now, rod.index)].xyz;
  uint next = rod.slots.next;
  g_state[stateIndex(kFrameSets + next, 0, strand)] = rod.rootFrame;
  g_state[strandIndex(kGuessedDisplacement, next, rod.index)] =
      float4(rolled.guessedDisplacement, 0.0);
  g_state[strandIndex(kFirstPosition, next, rod.index)] = float4(rod.x1, 0.0);
  g_state[strandIndex(kTipPosition, next, rod.index)] = float4(rolled.tip.x, 0.0);
  g_state[strandIndex(kRootVelocity, next, rod.index)] = float4(rootVelocity, 0.0);
  g_state[strandIndex(kTransportRotation, next, rod.index)] = rod.transported;
}

// Resets the state of a strand, or moves it to a new origin, as the flags say. Returns false if
// that is all.
bool prepareState(uint index) {
  Slots slots = slotsOfTile(index / kTileStrands);
  ExactStrand strand = strandAt(index);
  bool reset = (g_flags & kResetFlag) != 0u;
#if CONTACTS
  // By a pass of its own, which only does that.
  bool resets = reset && (g_flags & kPoseFlag) != 0u;
#else
  bool resets = reset;
#endif
  if (resets) resetStrand(strand, slots, rootAt(rootPath(strand.root), g_rootEnd), index);
  if ((g_flags & kPoseFlag) != 0u) return false;
  if ((g_flags & kRebaseFlag) != 0u && !reset) rebaseStrand(slots, index);
  return true;
}

#endif
