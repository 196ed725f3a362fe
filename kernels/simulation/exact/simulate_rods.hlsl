// Advances the guide strands by one sub-step: the exact tier, an inextensible Kirchhoff rod that is
// implicit in time, solved directly along each strand.
//
// Threads: one a strand in the order of g_strands; dispatch min(count, 2^20) x ceil(count / 2^20).
//          No barriers and no shared memory; a strand of any count from 2 to 256 is a loop.
// Reads:   g_strands, g_rootFrames, g_rest, g_state (now and before), g_exactColliders, g_forces,
//          g_sleep
// Writes:  g_state (next; at a reset now and before), g_gains, g_positions, g_tangents, g_sleep
//
// In this order (numbers of the step in layouts/exact.hlsli):
//   1. Vertices 0, 1 and edge 0 go where the root is at the sub-step's end. A new origin of the
//      object moves the state first.
//   2. VELOCITY_SHOCK_PROPAGATION: positions, velocities and frames, of now and before, are carried
//      along by a share of the root's rigid motion.
//   3. Every vertex's target y = xb + vb velocityShare + drift, BDF2 or backward Euler of a free
//      vertex with air drag; GLOBAL_SHAPE: drawn to its goal. Every edge's guess: it turns on.
//   4. Tip to root, the elimination (rod_elimination.hlsli), with COLLIDERS' contacts and friction.
//   5. Root to tip, the roll-out: rotations of the edges, positions by summing the edges, out of
//      the colliders; velocities v = (x - xb) / he; positions and tangents for drawing.
//   6. 4 and 5 once more, about the result, where an edge turned by more than g_passTolerance.
//      Without it strands that whip about gain energy.
// DAMPING: Kelvin-Voigt damping of the bending and the twist.
// FORCES: accelerations and drags of a buffer, in step 3.
// With the sleep flag the threads are those of the tiles that select_awake_tiles has found awake.
//
// Rounding: positions enter the solve as ways over the step, summed along the strand from the
// differences of tangents. A difference of positions that were summed in two ways is off by 1e-7 m,
// which the weights of 1e4/s2 make into a steady force.
//
// Invariant (tests/kernel): edges have their rest lengths to rounding; the rest pose without
// gravity is a fixed point to rounding; nothing finite gives a NaN; a NaN in what moves of the
// state (not in lengths, regions and the rest shape) is gone after a few steps; a strand whose
// record does not fit its buffers is left out; the result of a strand depends on no other one, and
// agrees with tests/reference/rod bit by bit where the device's square root and division are exact.
#include "../../common/random_hash.hlsli"
#include "rod_elimination.hlsli"

// Vertices a strand may have.
static const uint kMinCount = 2;
static const uint kMaxCount = 256;
// Goal spring of a vertex that is held [1/s2]; with 1e8 two passes do not converge.
static const float kHoldStiffness = 1e6;
static const uint kResetFlag = 1;
static const uint kLastFlag = 2;
static const uint kRebaseFlag = 4;
static const uint kSleepFlag = 8;
// Words of g_sleep before the list of tiles.
static const uint kSleepHead = 8;

// What a vertex has in memory.
struct StoredVertex {
  float4 now;             // x, w = length of the edge behind
  float4 before;          // x_-1
  float4 velocity;        // v, w = region
  float4 velocityBefore;  // v_-1
  float4 rest;            // rotation of the joint at rest
#if GLOBAL_SHAPE
  float4 goal;
#endif
#if FORCES
  float4 force;
#endif
  float4 factors;
};

StoredVertex loadVertex(uint vertex, ExactStrand strand, Slots slots) {
  StoredVertex stored;
  stored.now = g_state[stateIndex(kPositionSets + slots.now, vertex, strand)];
  stored.before = g_state[stateIndex(kPositionSets + slots.before, vertex, strand)];
  stored.velocity = g_state[stateIndex(kVelocitySets + slots.now, vertex, strand)];
  stored.velocityBefore = g_state[stateIndex(kVelocitySets + slots.before, vertex, strand)];
  stored.rest = g_rest[stateIndex(0, vertex, strand)];
#if GLOBAL_SHAPE
  stored.goal = g_rest[stateIndex(1, vertex, strand)];
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
  float4 before;
  float4 next;  // after the first pass
};

StoredEdge loadEdge(uint edge, ExactStrand strand, Slots slots, uint pass) {
  StoredEdge stored;
  stored.now = g_state[stateIndex(kFrameSets + slots.now, edge, strand)];
  stored.before = g_state[stateIndex(kFrameSets + slots.before, edge, strand)];
  stored.next = stored.now;
  if (pass > 0) stored.next = g_state[stateIndex(kFrameSets + slots.next, edge, strand)];
  return stored;
}

// A free edge in a pass.
RodEdge freeEdge(StoredEdge stored, Carry carry, float edgeLength, uint pass) {
  RodEdge edge;
  edge.frame = carryFrame(carry, stored.now);
  float4 before = carryFrameBefore(carry, stored.before);
  edge.guess = guessFrame(edge.frame, before, g_turnRatio, g_slowTurn);
  edge.iterate = edge.guess;
  if (pass > 0) edge.iterate = stored.next;
  edge.edgeLength = edgeLength;
  return edge;
}

// Edge 0.
RodEdge rootEdge(StoredEdge stored, Carry carry, float4 frame) {
  RodEdge edge;
  edge.frame = carryFrame(carry, stored.now);
  edge.guess = frame;
  edge.iterate = frame;
  edge.edgeLength = 0.0;
  return edge;
}

// Way of an edge's end against its begin, in the iterate.
float3 edgeWay(RodEdge edge) {
  precise float3 r = (axisX(edge.iterate) - axisX(edge.frame)) * edge.edgeLength;
  return r;
}

// What an acceleration a and a drag k add to the equation of a free vertex.
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
    acceleration = acceleration + stored.force.xyz;
  }
#endif
  ExtraForce extra;
  extra.acceleration = acceleration;
  extra.drag = drag;
  return extra;
}

// Way in a step by gravity and wind. Every strand has a phase of the gusts of its own.
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

RodVertex freeVertex(StoredVertex stored, Carry carry, RodRoot root, float3 drift) {
  float3 now = carryPoint(carry, stored.now.xyz);
  precise float3 xb = carriedWayBack(carry, stored.now.xyz, stored.before.xyz) * g_historyShare;
  float3 vb =
      carriedVelocity(carry, stored.velocity.xyz, stored.velocityBefore.xyz, g_historyShare);
  precise float3 target = xb + vb * g_velocityShare + drift;
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
    precise float3 pushed =
        xb + (vb * g_velocityShare + drift) * share + extra.acceleration / heavier;
    target = pushed;
    weight = heavier;
  }
#if GLOBAL_SHAPE
  float spring = kHoldStiffness;
  if (stored.goal.w >= 0.0) {
    precise float fade = 0.25 * g_goalRange;
    precise float within = (g_goalRange + fade - stored.goal.w) / fade;
    precise float faded = g_goalStiffness * stored.factors.y * min(max(within, 0.0), 1.0);
    spring = faded;
  }
  if (spring > 0.0) {
    precise float3 goal = root.position + rotate(root.rotation, stored.goal.xyz);
    weight = weight + spring;
    target = target + (goal - now - target) * (spring / weight);
  }
#endif
  RodVertex vertex;
  vertex.position = now;
  vertex.target = target;
  vertex.region = stored.velocity.w;
  precise float am = stored.velocity.w * weight;
  vertex.weight = am;
  return vertex;
}

// Writes the rest shape at the root's pose, at rest, into the states now and before.
void resetStrand(ExactStrand strand, Slots slots, RodRoot root) {
  float4 rootRest = g_rest[stateIndex(0, 0, strand)];
  float4 frame = normalizeProduct(multiplyQuaternions(root.rotation, rootRest));
  precise float3 x = root.position;
  for (uint i = 0; i < strand.count; ++i) {
    uint now = stateIndex(kPositionSets + slots.now, i, strand);
    uint before = stateIndex(kPositionSets + slots.before, i, strand);
    float edgeLength = g_state[now].w;
    float region = g_state[stateIndex(kVelocitySets + slots.now, i, strand)].w;
    if (i + 1 == strand.count) {
      frame = float4(0.0, 0.0, 0.0, 1.0);
    } else if (i > 0) {
      float4 rest = g_rest[stateIndex(0, i, strand)];
      frame = normalizeProduct(multiplyQuaternions(frame, rest));
    }
    g_state[now] = float4(x, edgeLength);
    g_state[before] = float4(x, edgeLength);
    g_state[stateIndex(kVelocitySets + slots.now, i, strand)] = float4(0.0, 0.0, 0.0, region);
    g_state[stateIndex(kVelocitySets + slots.before, i, strand)] = float4(0.0, 0.0, 0.0, region);
    g_state[stateIndex(kFrameSets + slots.now, i, strand)] = frame;
    g_state[stateIndex(kFrameSets + slots.before, i, strand)] = frame;
    x = x + axisX(frame) * edgeLength;
  }
}

// Moves the states now and before to the new origin, and the motion that led from one to the other.
void rebaseStrand(ExactStrand strand, Slots slots) {
  float3 shift = g_rebase.xyz;
  for (uint i = 1; i < strand.count; ++i) {
    uint now = stateIndex(kPositionSets + slots.now, i, strand);
    uint before = stateIndex(kPositionSets + slots.before, i, strand);
    float4 x = g_state[now];
    float4 xBefore = g_state[before];
    precise float3 moved = x.xyz + shift;
    precise float3 movedBefore = xBefore.xyz + shift;
    g_state[now] = float4(moved, x.w);
    g_state[before] = float4(movedBefore, xBefore.w);
  }
#if VELOCITY_SHOCK_PROPAGATION
  // p -> R p + s about another origin: s + d - R d.
  uint spare = stateIndex(kVelocitySets + slots.now, 1, strand);
  float4 rotation = g_state[stateIndex(kFrameSets + slots.now, strand.count - 1, strand)];
  float4 motion = g_state[spare];
  precise float3 moved = motion.xyz + (shift - rotate(rotation, shift));
  g_state[spare] = float4(moved, motion.w);
#endif
}

// Position and tangent for drawing. A vertex's tangent is the direction from the vertex before to
// the one after; at the two ends, that of the only edge.
void writeOutput(uint vertex, ExactStrand strand, float3 x, float3 across, float3 fallback) {
  precise float3 world = x + g_origin.xyz;
  g_positions[strand.target + vertex] = float4(world, vertex < 2 ? 0.0 : 1.0);
  g_tangents[strand.target + vertex] = float4(directionOr(across, fallback), 0.0);
}

// The rotation of an edge by its control law, made finite and at most kStepLimit; w = its square
// before the limit.
float4 limitedTurn(float3 u) {
  precise float size = abs(u.x) + abs(u.y) + abs(u.z);
  precise float3 turn = u;
  // On the bits, because a driver may assume that no float is a NaN: below 1e30.
  if (asuint(size) >= 0x7149f2cau) {
    turn = float3(0.0, 0.0, 0.0);
  } else if (size > 4.0) {
    // Before it is squared: the square of a huge rotation would not be a number.
    precise float factor = 4.0 / size;
    turn = turn * factor;
  }
  precise float squared = dot3(turn, turn);
  if (squared > kStepLimit * kStepLimit) {
    precise float factor = kStepLimit * inverseRoot(squared);
    turn = turn * factor;
  }
  return float4(turn, squared);
}

// Tip to root. \param tipWay way of the last vertex in the iterate
void eliminate(ExactStrand strand, Slots slots, Carry carry, RodRoot root, float4 rootFrame,
               float3 drift, uint pass, float3 tipWay) {
  uint last = strand.count - 2;  // edge
  StoredVertex storedEnd = loadVertex(last + 1, strand, slots);
  StoredVertex stored = loadVertex(last, strand, slots);
  StoredEdge storedEdge = loadEdge(last, strand, slots, pass);
  StoredEdge storedParent = loadEdge(last - 1, strand, slots, pass);
  precise float3 way = tipWay;
  RodVertex vertex = freeVertex(storedEnd, carry, root, drift);
  Value value = addVertex(emptyValue(), vertex, way);
  RodEdge edge = freeEdge(storedEdge, carry, stored.now.w, pass);
  [loop] for (uint i = last; i >= 1; --i) {
    // Loads of the next turn, before this turn's arithmetic.
    StoredVertex storedNext = loadVertex(i - 1, strand, slots);
    StoredEdge storedGrandparent = loadEdge(i > 1 ? i - 2 : 0, strand, slots, pass);

    RodEdge parent = rootEdge(storedParent, carry, rootFrame);
    if (i > 1) parent = freeEdge(storedParent, carry, storedNext.now.w, pass);
    float3 turned = float3(0.0, 0.0, 0.0);
    if (pass > 0) turned = turnBetween(edge.iterate, edge.guess);
    // Stiffness is over the region: a stiffer joint is one of a smaller region.
    precise float region = stored.velocity.w / max(stored.factors.x, 1e-6);
    way = way - edgeWay(edge);
    Bending bending = bendingOf(edge, parent, stored.rest, region);
    Elimination step = eliminateEdge(value, edge, bending, region, vertex.weight, turned);
    storeGain(i, strand, step.gain);
    value = step.value;
    vertex = freeVertex(stored, carry, root, drift);
    if (i > 1) value = addVertex(value, vertex, way);

    stored = storedNext;
    storedParent = storedGrandparent;
    edge = parent;
  }
}

struct RollOut {
  float largest;       // square of the largest rotation [rad^2]
  float fastest;       // square of the highest speed [m2/s2]
  float3 way;          // of the tip against vertex 1, in the new iterate
  float3 guessedWay;   // the same in the next step's guess, against the new positions
};

// Root to tip.
RollOut rollOut(ExactStrand strand, Slots slots, Carry carry, float3 x0, float3 x1,
                float4 rootFrame, uint pass) {
  uint count = strand.count;
  RollOut result;
  result.largest = 0.0;
  result.fastest = 0.0;
  precise float3 way = float3(0.0, 0.0, 0.0);
  precise float3 guessedWay = float3(0.0, 0.0, 0.0);
  precise float3 x = x1;
  precise float3 dx = float3(0.0, 0.0, 0.0);
  precise float3 u = float3(0.0, 0.0, 0.0);
  float4 firstX = g_state[stateIndex(kPositionSets + slots.now, 0, strand)];
  float4 frameBefore = rootFrame;
  float3 edgeBefore = axisX(rootFrame);
  precise float3 edgeVector = edgeBefore * firstX.w;
  writeOutput(0, strand, x0, edgeVector, edgeBefore);

  float4 now = g_state[stateIndex(kPositionSets + slots.now, 1, strand)];
  float4 before = g_state[stateIndex(kPositionSets + slots.before, 1, strand)];
  float region = g_state[stateIndex(kVelocitySets + slots.now, 1, strand)].w;
  StoredEdge storedEdge = loadEdge(1, strand, slots, pass);
  PackedGain packed = loadGain(1, strand);
  [loop] for (uint i = 1; i < count; ++i) {
    // Loads of the next turn, before this turn's arithmetic.
    uint after = min(i + 1, count - 1);
    uint edgeAfter = min(i + 1, count - 2);
    float4 nowNext = g_state[stateIndex(kPositionSets + slots.now, after, strand)];
    float4 beforeNext = g_state[stateIndex(kPositionSets + slots.before, after, strand)];
    float regionNext = g_state[stateIndex(kVelocitySets + slots.now, after, strand)].w;
    StoredEdge storedNext = loadEdge(edgeAfter, strand, slots, pass);
    PackedGain packedNext = loadGain(edgeAfter, strand);

    g_state[stateIndex(kPositionSets + slots.next, i, strand)] = float4(x, now.w);
    if (i > 1) {
      float3 old = carryPoint(carry, now.xyz);
      precise float3 back = old + carriedWayBack(carry, now.xyz, before.xyz) * g_historyShare;
      precise float3 v = (x - back) * g_inverseStep;
      result.fastest = max(result.fastest, dot3(v, v));
      g_state[stateIndex(kVelocitySets + slots.next, i, strand)] = float4(v, region);
    }
    precise float3 across = edgeVector;
    precise float3 xNext = x;
    if (i + 1 < count) {
      RodEdge edge = freeEdge(storedEdge, carry, now.w, pass);
      Gain g = unpackGain(packed);
      precise float3 law = g.kw0 * u.x + g.kw1 * u.y + g.kw2 * u.z - g.k - g.kx0 * dx.x -
                           g.kx1 * dx.y - g.kx2 * dx.z;
      float4 limited = limitedTurn(law);
      u = limited.xyz;
      result.largest = max(result.largest, limited.w);
      float4 frame = turnedBy(u, edge.iterate);
#if COLLIDERS
      frame = keepOut(x, frame, edge.edgeLength);
#endif
      // A state that was not a number: the edge goes on as the one before it.
      if (!isUsable(frame)) frame = frameBefore;
      frameBefore = frame;
      g_state[stateIndex(kFrameSets + slots.next, i, strand)] = frame;
      float3 tangent = axisX(frame);
      edgeVector = tangent * edge.edgeLength;
      across = across + edgeVector;
      xNext = x + edgeVector;
      dx = dx + (tangent - axisX(edge.iterate)) * edge.edgeLength;
      way = way + (tangent - axisX(edge.frame)) * edge.edgeLength;
      float3 goingOn = axisX(guessFrame(frame, edge.frame, 1.0, g_slowTurn));
      guessedWay = guessedWay + (goingOn - tangent) * edge.edgeLength;
      edgeBefore = tangent;
    }
    writeOutput(i, strand, x, across, edgeBefore);
    x = xNext;
    now = nowNext;
    before = beforeNext;
    region = regionNext;
    storedEdge = storedNext;
    packed = packedNext;
  }
  result.way = way;
  result.guessedWay = guessedWay;
  return result;
}

// Way of the tip against vertex 1 in the guess.
float3 guessedTipWay(ExactStrand strand, Slots slots, Carry carry) {
  precise float3 way = float3(0.0, 0.0, 0.0);
  StoredEdge stored = loadEdge(1, strand, slots, 0);
  float edgeLength = g_state[stateIndex(kPositionSets + slots.now, 1, strand)].w;
  [loop] for (uint i = 1; i + 1 < strand.count; ++i) {
    StoredEdge storedNext = loadEdge(i + 1, strand, slots, 0);
    float lengthNext = g_state[stateIndex(kPositionSets + slots.now, i + 1, strand)].w;
    way = way + edgeWay(freeEdge(stored, carry, edgeLength, 0));
    stored = storedNext;
    edgeLength = lengthNext;
  }
  return way;
}

[numthreads(32, 1, 1)]
void simulate_rods(uint3 thread : SV_DispatchThreadID) {
  uint index = (thread.y << 20) | thread.x;
  bool sleeping = (g_flags & kSleepFlag) != 0u;
  uint tiles = (g_strandCount + kTileStrands - 1) / kTileStrands;
  if (sleeping) {
    uint entry = index / kTileStrands;
    if (entry >= tiles) return;
    index = g_sleep[kSleepHead + entry] * kTileStrands + index % kTileStrands;
  }
  if (index >= g_strandCount) return;
  ExactStrand strand = g_strands[index];
  if (strand.count < kMinCount || strand.count > kMaxCount) return;
  uint reach = (strand.count - 1) * kTileStrands;
  if (reach >= g_stateStride || strand.state >= g_stateStride - reach) return;
  uint outputs = max(strand.count, g_outputVertices);
  if (outputs > g_outputCount || strand.target > g_outputCount - outputs) return;
  if (strand.root >= g_rootCount) return;

  Slots slots = stateSlots(g_sleep[kSleepHead + tiles + index / kTileStrands]);
  RootPath path = rootPath(strand.root);
  RodRoot begin = rootAt(path, g_rootBegin);
  RodRoot root = rootAt(path, g_rootEnd);
  bool reset = (g_flags & kResetFlag) != 0u;
  if (reset) resetStrand(strand, slots, root);
  if ((g_flags & kRebaseFlag) != 0u && !reset) rebaseStrand(strand, slots);

  uint tip = strand.count - 1;
  float4 firstX = g_state[stateIndex(kPositionSets + slots.now, 0, strand)];
  float4 firstV = g_state[stateIndex(kVelocitySets + slots.now, 0, strand)];
  precise float3 rootVelocity = (path.to.position - path.from.position) / g_frameTime;
  RigidMotion carried = noMotion();
  Carry carry;
#if VELOCITY_SHOCK_PROPAGATION
  carry.now = carried;
  carry.before = carried;
  carry.both = carried.rotation;
  if (!reset) {
    precise float3 change = rootVelocity - firstV.xyz;
    precise float between = 0.5 * (g_frameTime + g_frameTimeBefore);
    precise float acceleration = squareRoot(dot3(change, change)) / between;
    precise float excess = min(max(acceleration / g_vspThreshold - 1.0, 0.0), 1.0);
    precise float share = g_vspCoefficient + (1.0 - g_vspCoefficient) * excess;
    carried = carriedMotion(begin, root, share);
    RigidMotion last;
    last.rotation = g_state[stateIndex(kFrameSets + slots.now, tip, strand)];
    last.shift = g_state[stateIndex(kVelocitySets + slots.now, 1, strand)].xyz;
    carry.now = carried;
    carry.before = last;
    carry.both = normalizeProduct(multiplyQuaternions(carried.rotation, last.rotation));
  }
#else
  carry.unused = 0;
#endif

  float4 rootRest = g_rest[stateIndex(0, 0, strand)];
  float4 rootFrame = normalizeProduct(multiplyQuaternions(root.rotation, rootRest));
  float3 x0 = root.position;
  precise float3 edge0 = axisX(rootFrame) * firstX.w;
  precise float3 x1 = x0 + edge0;

  float3 drift = strandDrift(strand);
  precise float3 guessedWay = float3(0.0, 0.0, 0.0);
  float fastest = 0.0;
  if (strand.count > 2) {
    float3 oldX1 =
        carryPoint(carry, g_state[stateIndex(kPositionSets + slots.now, 1, strand)].xyz);
    precise float3 rootWay = x1 - oldX1;
    precise float3 way = firstX.xyz;
#if VELOCITY_SHOCK_PROPAGATION
    // The last sub-step's sum, turned, would differ from the sum of the turned edges by its
    // rounding.
    way = guessedTipWay(strand, slots, carry);
#else
    if (g_turnRatio != 1.0 || reset) way = guessedTipWay(strand, slots, carry);
#endif
    RollOut rolled;
    precise float tolerance2 = g_passTolerance * g_passTolerance;
    [loop] for (uint pass = 0; pass < 2; ++pass) {
      precise float3 tipWay = way + rootWay;
      eliminate(strand, slots, carry, root, rootFrame, drift, pass, tipWay);
      rolled = rollOut(strand, slots, carry, x0, x1, rootFrame, pass);
      way = rolled.way;
      if (rolled.largest <= tolerance2) break;
      if (sleeping && pass == 0) InterlockedAdd(g_sleep[7], 1u);
    }
    guessedWay = rolled.guessedWay;
    fastest = rolled.fastest;
  } else {
    float3 tangent = axisX(rootFrame);
    writeOutput(0, strand, x0, edge0, tangent);
    writeOutput(1, strand, x1, edge0, tangent);
    float4 secondX = g_state[stateIndex(kPositionSets + slots.now, 1, strand)];
    g_state[stateIndex(kPositionSets + slots.next, 1, strand)] = float4(x1, secondX.w);
  }

  uint tipTarget = strand.target + tip;
  for (uint pad = strand.count; pad < g_outputVertices; ++pad) {
    g_positions[strand.target + pad] = g_positions[tipTarget];
    g_tangents[strand.target + pad] = g_tangents[tipTarget];
  }

  if (sleeping && (g_flags & kLastFlag) != 0u) {
    uint word = kSleepHead + 2 * tiles + index;
    precise float rested = asfloat(g_sleep[word]) + g_frameTime;
    // Not below the limit, also where it is not a number: the strand moves.
    if (!(fastest < g_restSpeed * g_restSpeed)) rested = 0.0;
    g_sleep[word] = asuint(rested);
  }

  // The spare places of the new state.
  bool lastSubStep = (g_flags & kLastFlag) != 0u;
  if (!lastSubStep) rootVelocity = firstV.xyz;
  float region1 = g_state[stateIndex(kVelocitySets + slots.now, 1, strand)].w;
  g_state[stateIndex(kPositionSets + slots.next, 0, strand)] = float4(guessedWay, firstX.w);
  g_state[stateIndex(kVelocitySets + slots.next, 0, strand)] = float4(rootVelocity, firstV.w);
  g_state[stateIndex(kVelocitySets + slots.next, 1, strand)] = float4(carried.shift, region1);
  g_state[stateIndex(kFrameSets + slots.next, 0, strand)] = rootFrame;
  g_state[stateIndex(kFrameSets + slots.next, tip, strand)] = carried.rotation;
}
