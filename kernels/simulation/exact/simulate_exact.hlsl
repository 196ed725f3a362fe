// Advances the guide strands by one sub-step: the exact solver, an inextensible Kirchhoff rod that
// is implicit in time, solved directly along each strand.
//
// Threads: one per strand in the order of the state; dispatch min(count, 2^20) x
//          ceil(count / 2^20). No barriers and no shared memory; a strand of any count from 2 to
//          256 is a loop.
// Reads:   g_rest, g_state (now, before, earlier), g_contacts,
//          g_contactWords, g_forces, g_sleep
// Writes:  g_state (next; at a reset the states that it reads; gains), g_positions, g_tangents,
//          g_sleep, g_contacts (forces and bits), g_contactWords (counters, the list of tiles)
//
// The steps, in this order (simulation/layouts/exact.hlsli has the numbers of a step):
//   1. Vertices 0, 1 and edge 0 take the pose of the root at the end of the sub-step. A new origin
//      of the object moves the state first.
//   2. VELOCITY_SHOCK_PROPAGATION: displacements and frames are transported by a fraction of the
//      root's rigid motion.
//   3. Every vertex gets a target, to which the last three displacements and the drift lead: BDF2
//      or backward Euler of a free vertex with air drag; GLOBAL_SHAPE: pulled to its bind-pose
//      target. Every edge gets a guess: it keeps rotating as the last step has stored in the w of
//      the displacement of the vertex at its end.
//   4. Tip to root, the elimination (exact_elimination.hlsli). CONTACTS: with the planes and
//      friction of the records of find_contacts (exact_contact.hlsli).
//   5. Root to tip, the roll-out: rotations of the edges, positions by summing the edges, out of
//      the planes; the displacements of this step; positions and tangents for drawing.
//   6. 4 and 5 once more, about the result, if an edge rotated by more than g_passTolerance.
//      Without it, whipping strands gain energy. Up to twice more if a contact has changed. A
//      strand with a vertex that ended far from where its contact was found is marked, and its tile
//      listed: the host has its contacts found again, and the pass continues from the result (flag
//      bit 7).
// With g_damping: Kelvin-Voigt damping of the bending and the twist.
// FORCES: accelerations and drags of a buffer, in step 3.
// With the sleep flag the threads are those of the tiles that select_awake_tiles has found awake.
//
// Speed: a strand is one thread, so the time depends first on the latency of a vertex through its
// loops, and with many strands on the bytes: 6 vectors are read and 6 written to the root, 7 read
// and 4 written to the tip. Loads are one iteration ahead. Square roots of numbers near 1 are short
// polynomials.
//
// Rounding: displacements are summed along the strand from the differences of tangents. A
// difference of positions that were summed in two orders is off by 1e-7 m, which the weights of
// 1e4/s2 make into a steady force.
//
// Invariant (tests/simulation): edges have their rest lengths to rounding; the rest pose without
// gravity is a fixed point to rounding; finite input gives no NaN; a NaN in the state (not in
// lengths, Voronoi lengths and the rest shape) is gone after a few steps; a strand whose record
// does not fit its buffers is skipped; the result of a strand depends on no other strand, and
// agrees with tests/reference/rod bit by bit where the device's square root and division are exact.
#include "../../base/dispatch.hlsli"
#include "../../base/random_hash.hlsli"
#include "exact_elimination.hlsli"

// Spring to the bind-pose target of a held vertex [1/s2]; with 1e8 two passes do not converge.
static const float kHoldStiffness = 1e6;
// Maximum passes of a strand with contacts; other strands take two at most.
static const uint kContactPassLimit = 3;

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

// \param x position in the iterate, \param displacement since the start of the step
RodVertex freeVertex(StoredVertex stored, Transport transport, RodRoot root, float3 drift, float3 x,
                     float3 displacement, bool overlaps) {
  precise float3 displacements =
      transportedDisplacements(transport, stored.displacement.xyz, stored.displacementBefore.xyz,
                               stored.displacementEarlier.xyz);
#if CONTACTS
  if (overlaps)
    displacements =
        limitedDisplacements(transport, stored.displacement.xyz, stored.displacementBefore.xyz,
                             stored.displacementEarlier.xyz);
#endif
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
    precise float3 targetDisplacement = bindTarget - x + displacement;
    weight = weight + spring;
    target = target + (targetDisplacement - target) * (spring / weight);
  }
#endif
  RodVertex vertex;
  vertex.displacement = displacement;
  vertex.x = x;
  vertex.target = target;
  vertex.voronoiLength = stored.rest.w;
  precise float am = stored.rest.w * weight;
  vertex.weight = am;
  return vertex;
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

// A strand in this sub-step.
struct RodStep {
  ExactStrand strand;
  uint index;  // of the strand
  Slots slots;
  Transport transport;
  RodRoot root;                 // at the end of the sub-step
  float4 rootFrame;             // of edge 0
  float3 edge0;                 // vector of edge 0 [m]
  float3 rootStepDisplacement;  // of vertex 1 [m]
  float3 drift;
  bool overlaps;  // a vertex has a contact
};

// Tip to root.
// \param tipDisplacement displacement of the last vertex in the iterate
// \param tipX   its position
void eliminate(RodStep rod, uint pass, float3 tipDisplacement, float3 tipX) {
  ExactStrand strand = rod.strand;
  Slots slots = rod.slots;
  Transport transport = rod.transport;
  uint last = strand.count - 2;  // edge
  StoredVertex storedEnd = loadVertex(last + 1, strand, slots);
  StoredVertex stored = loadVertex(last, strand, slots);
  StoredEdge storedEdge = loadEdge(last, strand, slots, pass);
  StoredEdge storedParent = loadEdge(last - 1, strand, slots, pass);
  precise float3 displacement = tipDisplacement;
  precise float3 x = tipX;
  RodVertex vertex =
      freeVertex(storedEnd, transport, rod.root, rod.drift, x, displacement, rod.overlaps);
  Value value = addVertex(emptyValue(), vertex);
#if CONTACTS
  uint mask = 0u;
  if (rod.overlaps) mask = contactMask(rod.index, last + 1);
  if (!rod.overlaps) value.load = 1e30;
  if (hasContact(mask, last + 1))
    value = addContacts(value, strand, last + 1, loadContact(recordOf(strand, last + 1)), vertex,
                        transport);
#endif
  RodEdge edge = freeEdge(storedEdge, storedEnd.displacement.w, transport, stored.rest.z, pass);
  [loop] for (uint i = last; i >= 1; --i) {
    // Loads of the next iteration, before the arithmetic of this one.
    StoredVertex storedNext = loadVertex(i - 1, strand, slots);
    StoredEdge storedGrandparent = loadEdge(i > 1 ? i - 2 : 0, strand, slots, pass);
#if CONTACTS
    if (rod.overlaps && (i & 31u) == 31u) mask = contactMask(rod.index, i);
    bool inContact = i > 1 && hasContact(mask, i);
    StoredContact storedContact = noContact();
    if (inContact) storedContact = loadContact(recordOf(strand, i));
#endif

    RodEdge parent = rootEdge(storedParent, transport, rod.rootFrame);
    if (i > 1)
      parent = freeEdge(storedParent, stored.displacement.w, transport, storedNext.rest.z, pass);
    float3 rotated = float3(0.0, 0.0, 0.0);
    if (pass > 0) rotated = rotationBetween(edge.iterate, edge.guess);
    float3 tangent = axisX(edge.iterate);
    displacement = displacement - (tangent - axisX(edge.frame)) * edge.edgeLength;
    x = x - tangent * edge.edgeLength;
    // Stiffness is divided by the Voronoi length.
    precise float inverseVoronoiLength = max(stored.factors.x, 1e-6) / stored.rest.w;
    Bending bending = bendingOf(edge, parent, restRotation(stored.rest.xy), inverseVoronoiLength);
    precise float twistStiffness = g_twistStiffness * inverseVoronoiLength;
    Elimination step = eliminateEdge(value, edge, bending, twistStiffness, vertex.weight, rotated);
    storeGain(i, strand, step.gain);
    value = step.value;
    vertex = freeVertex(stored, transport, rod.root, rod.drift, x, displacement, rod.overlaps);
    if (i > 1) {
      value = addVertex(value, vertex);
#if CONTACTS
      if (inContact) value = addContacts(value, strand, i, storedContact, vertex, transport);
#endif
    }

    stored = storedNext;
    storedParent = storedGrandparent;
    edge = parent;
  }
}

struct RollOut {
  float largest;               // square of the largest rotation [rad^2]
  float farthest;              // square of the largest displacement [m2]
  float3 displacement;         // of the tip relative to vertex 1, in the new iterate
  float3 guessedDisplacement;  // the same in the next step's guess, against the new positions
  float3 tip;                  // new position
#if CONTACTS
  bool changed;  // the contacts need another pass
  bool far;      // they are far from where they were found
#endif
};

// Root to tip.
RollOut rollOut(RodStep rod, uint pass) {
  ExactStrand strand = rod.strand;
  Slots slots = rod.slots;
  Transport transport = rod.transport;
  uint last = strand.count - 2;  // edge
  RollOut result;
  result.largest = 0.0;
  result.farthest = 0.0;
  precise float3 displacement = float3(0.0, 0.0, 0.0);
  precise float3 guessedDisplacement = float3(0.0, 0.0, 0.0);
  precise float3 x = rod.root.position + rod.edge0;
  precise float3 dx = float3(0.0, 0.0, 0.0);
  precise float3 u = float3(0.0, 0.0, 0.0);
  float4 frameBefore = rod.rootFrame;
  precise float3 tangent = axisX(rod.rootFrame);
  precise float3 edgeBefore = rod.edge0;
  writeOutput(0, strand, rod.root.position, rod.edge0, tangent);
#if CONTACTS
  result.changed = false;
  result.far = false;
  precise float3 offset = float3(0.0, 0.0, 0.0);  // from the solution
  uint mask = 0u;
  if (rod.overlaps) mask = contactMask(rod.index, 0);
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
    bool inContact = hasContact(mask, i + 1);
    StoredContact storedContact = noContact();
    if (inContact) storedContact = loadContact(recordOf(strand, i + 1));
#endif

    Gain g = unpackGain(packed);
    precise float3 law =
        g.kw0 * u.x + g.kw1 * u.y + g.kw2 * u.z - g.k - g.kx0 * dx.x - g.kx1 * dx.y - g.kx2 * dx.z;
    float4 limited = limitedRotation(law);
    u = limited.xyz;
    result.largest = max(result.largest, limited.w);
    float4 old = transportFrame(transport, stored.now);
    float4 iterate = stored.next;
    if (pass == 0) iterate = guessFrame(old, g.halfRotation);
    float4 frame = rotatedBy(u, iterate);
#if CONTACTS
    if (rod.overlaps) {
      if (dot3(offset, offset) > 1e-18) frame = leadBack(frame, g.edgeLength, offset);
      if (inContact)
        frame = keepOut(recordOf(strand, i + 1), storedContact, x, frame, g.edgeLength, offset);
    }
#endif
    // A state that was not a number: the edge continues the previous one.
    if (!isUnit(frame)) frame = frameBefore;
    frameBefore = frame;
    g_state[stateIndex(kFrameSets + slots.next, i, strand)] = frame;
    tangent = axisX(frame);
    precise float3 edgeVector = tangent * g.edgeLength;
    precise float3 across = edgeBefore + edgeVector;
    writeOutput(i, strand, x, across, tangent);
    edgeBefore = edgeVector;
    x = x + edgeVector;
#if CONTACTS
    if (rod.overlaps) dx = dx + rotatedEdge(u, axisX(iterate) * g.edgeLength);
    if (!rod.overlaps) dx = dx + (tangent - axisX(iterate)) * g.edgeLength;
#else
    dx = dx + (tangent - axisX(iterate)) * g.edgeLength;
#endif
    displacement = displacement + (tangent - axisX(old)) * g.edgeLength;
    precise float3 wholeDisplacement = rod.rootStepDisplacement + displacement;
    result.farthest = max(result.farthest, dot3(wholeDisplacement, wholeDisplacement));
    float nextRotation = nextHalfRotation(frame, old, g.halfRotation, g_guessTrend, g_slowRotation);
#if CONTACTS
    if (inContact) {
      float3 moved = worldDisplacement(transport, x, wholeDisplacement);
      precise float3 solved = dx + offset;
      ContactResult contact = updateContacts(strand, i + 1, storedContact, x, moved, solved);
      result.changed = result.changed || contact.changed;
      result.far = result.far || contact.far;
      wholeDisplacement = wholeDisplacement - contact.taken;
    }
    wholeDisplacement = wholeDisplacement - offset;
#endif
    g_state[stateIndex(kDisplacementSets + slots.next, i + 1, strand)] =
        float4(wholeDisplacement, nextRotation);
    float4 goingOn = guessFrame(frame, halfRotationOn(nextRotation, 1.0));
    guessedDisplacement = guessedDisplacement + (axisX(goingOn) - tangent) * g.edgeLength;
    stored = storedNext;
    packed = packedNext;
  }
  writeOutput(last + 1, strand, x, edgeBefore, tangent);
  result.displacement = displacement;
  result.guessedDisplacement = guessedDisplacement;
  result.tip = x;
  return result;
}

// Returns the displacement of the tip relative to vertex 1 in the iterate of a pass.
float3 guessedTipDisplacement(ExactStrand strand, Slots slots, Transport transport, uint pass) {
  precise float3 displacement = float3(0.0, 0.0, 0.0);
  [loop] for (uint i = 1; i + 1 < strand.count; ++i) {
    StoredEdge stored = loadEdge(i, strand, slots, pass);
    float relativeRotation = g_state[stateIndex(kDisplacementSets + slots.now, i + 1, strand)].w;
    RodEdge edge =
        freeEdge(stored, relativeRotation, transport, g_rest[stateIndex(0, i, strand)].z, pass);
    displacement = displacement + (axisX(edge.iterate) - axisX(edge.frame)) * edge.edgeLength;
  }
  return displacement;
}

// Counts a pass beyond the first one.
void countPass(bool sleeping, bool overlaps) {
  if (sleeping) InterlockedAdd(g_sleep[kSleepSecondPasses], 1u);
#if CONTACTS
  if (overlaps) InterlockedAdd(g_contactWords[kContactPasses], 1u);
#endif
}

#if CONTACTS
// Marks a strand, and lists its tile once.
void findAgain(uint index) {
  uint tile = index / kTileStrands;
  uint before;
  InterlockedOr(g_contactWords[g_contactList + tileCount() + tile], 1u << (index % kTileStrands),
                before);
  if (before != 0u) return;
  uint entry;
  InterlockedAdd(g_contactWords[g_contactHead + kContactSolveArguments], 1u, entry);
  InterlockedAdd(g_contactWords[g_contactHead + kContactFindArguments], 1u);
  InterlockedAdd(g_contactWords[kContactTiles], 1u);
  g_contactWords[g_contactList + entry] = tile;
}
#endif

[numthreads(32, 1, 1)]
void simulate_exact(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  bool sleeping = (g_flags & kSleepFlag) != 0u;
  uint tiles = tileCount();
  uint firstPass = 0u;
#if CONTACTS
  bool again = (g_flags & kAgainFlag) != 0u;
  if (again) {
    uint entry = index / kTileStrands;
    if (entry >= min(g_contactWords[g_contactHead + kContactSolveArguments], tiles)) return;
    uint tile = g_contactWords[g_contactList + entry];
    // Not the index of its neighbors: a strand has the same bits in any order of strands.
    uint marks = g_contactWords[g_contactList + tiles + tile];
    if (((marks >> (index % kTileStrands)) & 1u) == 0u) return;
    index = tile * kTileStrands + index % kTileStrands;
    firstPass = 1u;
    sleeping = false;
  }
#endif
  if (sleeping) {
    uint entry = index / kTileStrands;
    if (entry >= tiles) return;
    index = g_sleep[kSleepHead + entry] * kTileStrands + index % kTileStrands;
  }
  if (index >= min(g_strandCount, g_simulatedCount)) return;
  ExactStrand strand = strandAt(index);
  if (!isSound(strand) || !fitsOutputs(strand)) return;

  Slots slots = slotsOfTile(index / kTileStrands);
  RootPath path = rootPath(strand.root);
  RodRoot begin = rootAt(path, g_rootBegin);
  RodRoot root = rootAt(path, g_rootEnd);
  bool reset = (g_flags & kResetFlag) != 0u;
  if (reset) resetStrand(strand, slots, root, index);
  if ((g_flags & kPoseFlag) != 0u) return;
  if ((g_flags & kRebaseFlag) != 0u && !reset) rebaseStrand(slots, index);

  uint tip = strand.count - 1;
  float3 rootVelocityBefore = g_state[strandIndex(kRootVelocity, slots.now, index)].xyz;
  precise float3 rootVelocity = (path.to.position - path.from.position) / g_frameTime;
  RigidMotion transported = noMotion();
  Transport transport;
#if VELOCITY_SHOCK_PROPAGATION
  if (!reset) {
    precise float3 change = rootVelocity - rootVelocityBefore;
    precise float between = 0.5 * (g_frameTime + g_frameTimeBefore);
    precise float acceleration = squareRoot(dot3(change, change)) / between;
    precise float excess = min(max(acceleration / g_vspThreshold - 1.0, 0.0), 1.0);
    precise float share = g_vspCoefficient + (1.0 - g_vspCoefficient) * excess;
    transported = transportedMotion(begin, root, share);
  }
  transport = transportOf(transported, g_state[strandIndex(kTransportRotation, slots.now, index)],
                          g_state[strandIndex(kTransportRotation, slots.before, index)]);
#else
  transport.unused = 0;
#endif

  float4 rootRest = g_rest[stateIndex(0, 0, strand)];
  float4 rootFrame = normalizeProduct(multiplyQuaternions(root.rotation, rootRest));
  float3 x0 = root.position;
  precise float3 edge0 = axisX(rootFrame) * g_rest[stateIndex(0, tip, strand)].x;
  precise float3 x1 = x0 + edge0;

  float3 drift = strandDrift(strand);
  RollOut rolled;
  rolled.largest = 0.0;
  rolled.farthest = 0.0;
  rolled.displacement = float3(0.0, 0.0, 0.0);
  rolled.guessedDisplacement = float3(0.0, 0.0, 0.0);
  rolled.tip = x1;
  if (strand.count > 2) {
    float3 oldX1 =
        transportPoint(transport, g_state[strandIndex(kFirstPosition, slots.now, index)].xyz);
    float3 oldTip =
        transportPoint(transport, g_state[strandIndex(kTipPosition, slots.now, index)].xyz);
    precise float3 rootStepDisplacement = x1 - oldX1;
    precise float3 displacement = transportDisplacement(
        transport, g_state[strandIndex(kGuessedDisplacement, slots.now, index)].xyz);
    if ((g_flags & kChangedFlag) != 0u || reset || firstPass > 0u)
      displacement = guessedTipDisplacement(strand, slots, transport, firstPass);
    precise float3 tipX = oldTip + (displacement + rootStepDisplacement);
    precise float tolerance2 = g_passTolerance * g_passTolerance;
    bool overlaps = false;
    uint passes = 2u;
#if CONTACTS
    overlaps = touchesAnything(index, strand.count);
    if (overlaps) passes = kContactPassLimit;
    if (again && !overlaps) return;
#endif
    RodStep rod;
    rod.strand = strand;
    rod.index = index;
    rod.slots = slots;
    rod.transport = transport;
    rod.root = root;
    rod.rootFrame = rootFrame;
    rod.edge0 = edge0;
    rod.rootStepDisplacement = rootStepDisplacement;
    rod.drift = drift;
    rod.overlaps = overlaps;
    [loop] for (uint pass = firstPass; pass < firstPass + passes; ++pass) {
      precise float3 tipDisplacement = displacement + rootStepDisplacement;
      eliminate(rod, pass, tipDisplacement, tipX);
      rolled = rollOut(rod, pass);
      displacement = rolled.displacement;
      tipX = rolled.tip;
      bool enough = rolled.largest <= tolerance2 || (pass > 0u && !overlaps);
#if CONTACTS
      bool rotated = rolled.largest > min(tolerance2, kContactRotation * kContactRotation);
      if (overlaps) enough = !rotated && !rolled.changed;
#endif
      if (enough) break;
      if (pass + 1u < firstPass + passes) countPass(sleeping, overlaps);
    }
#if CONTACTS
    if (overlaps && rolled.far && !again) findAgain(index);
#endif
  } else {
    float3 tangent = axisX(rootFrame);
    writeOutput(0, strand, x0, edge0, tangent);
    writeOutput(1, strand, x1, edge0, tangent);
  }

  uint tipTarget = strand.target + tip;
  for (uint pad = strand.count; pad < g_outputVertices; ++pad) {
    g_positions[strand.target + pad] = g_positions[tipTarget];
    g_tangents[strand.target + pad] = g_tangents[tipTarget];
  }

  if ((g_flags & kSleepFlag) != 0u && (g_flags & kLastFlag) != 0u) {
    uint word = kSleepHead + 2 * tiles + index;
    precise float rested = asfloat(g_sleep[word]) + (firstPass > 0u ? 0.0 : g_frameTime);
    // Negated, so that a NaN counts as motion.
    precise float restDisplacement = g_restSpeed * (g_frameTime * (g_rootEnd - g_rootBegin));
    if (!(rolled.farthest < restDisplacement * restDisplacement)) rested = 0.0;
    g_sleep[word] = asuint(rested);
  }

  bool lastSubStep = (g_flags & kLastFlag) != 0u;
  if (!lastSubStep) rootVelocity = rootVelocityBefore;
  g_state[stateIndex(kFrameSets + slots.next, 0, strand)] = rootFrame;
  g_state[strandIndex(kGuessedDisplacement, slots.next, index)] =
      float4(rolled.guessedDisplacement, 0.0);
  g_state[strandIndex(kFirstPosition, slots.next, index)] = float4(x1, 0.0);
  g_state[strandIndex(kTipPosition, slots.next, index)] = float4(rolled.tip, 0.0);
  g_state[strandIndex(kRootVelocity, slots.next, index)] = float4(rootVelocity, 0.0);
  g_state[strandIndex(kTransportRotation, slots.next, index)] = transported.rotation;
}
