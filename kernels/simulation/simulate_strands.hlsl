// Advances the guide strands by one sub-step: the classic tier, in one pass over each strand.
//
// Threads: one a guide strand; dispatch g_guideCount x 1. No barriers and no shared memory: a
//          strand is as long as it is, and the result does not depend on the group size.
// Reads:   g_rest, g_rootTransforms, g_state
// Writes:  g_state, g_positions and g_tangents of the guides
//
// In this order (h the sub-step; maps of the constants in layouts/simulation.hlsli):
//   1. The root's pose at the sub-step's begin and end. Held vertices (0, 1, and those of inverse
//      mass 0) go to their bind position in the end pose.
//   2. VELOCITY_SHOCK_PROPAGATION: current and previous positions are carried along by a share of
//      the root's rigid motion.
//   3. Free motion: u = (x - x_-1) (h / h_-1) keep + gravityStep g.
//   4. WIND: u += k P (h w - u), P = I - t t^T, k = c h / (1 + c h): implicit Euler for
//      dv/dt = c P (w - v), the drag of a thin fibre on the flow across it. Stable for every c h,
//      along the wind for every sign of it, at the tip too, and the same for short and long
//      segments. t is from the positions before the step.
//   5. |u| <= h maxSpeed; x <- x + u.
//   6. GLOBAL_SHAPE: a share of the way to the goal, the bind position in the end pose.
//   7. LOCAL_SHAPE: from root to tip each segment goes towards its rest vector in the frame that is
//      carried along the strand without twist; each end moves half of the way.
//   8. Length: Newton steps on all segments at once (tridiagonal), then follow the leader from the
//      root: exact lengths. Between two held vertices there is no leader: see fitSpan().
//   9. State, positions and tangents are written.
// Wind comes before the shapes, so that the drag acts on velocities and not on their corrections.
// Gravity acts at every share of 2.: that is part in the root's motion, not stiffness.
//
// Invariant (tests/kernel): free strands have their rest lengths to rounding after every step; the
// rest pose without gravity is a fixed point to rounding; nothing finite gives a NaN; a vertex
// whose state is not a number, or above 1e18, takes its goal.
#include "../common/quaternion.hlsli"
#include "../common/root_pose.hlsli"
#include "../common/strand_indexing.hlsli"

// Guard of the loops against constants that are out of their range.
static const uint kMaxIterations = 64;
// Passes over a span between two held vertices: nearly taut spans of 11 segments under gravity and
// wind are then stretched by 0.35 % at worst.
static const uint kSpanRounds = 16;
// A pivot of the length solve below this share of its diagonal means a folded strand, whose
// segments depend on each other; without the floor one step may leave the float range.
static const float kLeastPivot = 1e-4;

float3 restPosition(uint vertex, uint guide) { return g_rest[guideIndex(0, vertex, guide)].xyz; }

float inverseMass(uint vertex, uint guide) {
  if (vertex < 2) return 0.0;
  return g_rest[guideIndex(0, vertex, guide)].w > 0.0 ? 1.0 : 0.0;
}

float restLength(uint segment, uint guide) { return g_rest[guideIndex(1, segment, guide)].w; }

float3 position(uint vertex, uint guide) { return g_state[guideIndex(0, vertex, guide)].xyz; }

void setPosition(uint vertex, uint guide, float3 value) {
  g_state[guideIndex(0, vertex, guide)] = float4(value, 0.0);
}

// ---- root

// Frame of the first segment in a pose.
float4 firstFrame(uint guide, RootPose pose) {
  float4 bind = g_rest[guideIndex(1, g_vertexCount - 1, guide)];
  return normalizeQuaternion(multiplyQuaternions(pose.rotation, bind));
}

// Direction of the first segment in a pose. From the positions; the frame's x axis is the same, but
// has lost digits where the segment runs against the bind space's x axis.
float3 firstDirection(uint guide, float3 bindRoot, RootPose pose, float4 rootFrame) {
  precise float3 segment = restPosition(1, guide) - bindRoot;
  return directionOr(rotate(pose.rotation, segment), rotate(rootFrame, float3(1.0, 0.0, 0.0)));
}

// A rigid motion: p -> p + rotationDelta(rotation, p - pivot) + shift.
struct Motion {
  float4 rotation;
  float3 pivot;
  float3 shift;
};

float3 carried(Motion motion, float3 p) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 arm = p - motion.pivot;
  precise float3 r = p + (rotationDelta(motion.rotation, arm) + motion.shift);
  return r;
#else
  return p;
#endif
}

Motion rootMotion(uint guide, RootPose begin, RootPose end) {
  Motion motion;
  motion.rotation = float4(0.0, 0.0, 0.0, 1.0);
  motion.pivot = begin.position;
  motion.shift = float3(0.0, 0.0, 0.0);
#if VELOCITY_SHOCK_PROPAGATION
  // Acceleration of the root over two sub-steps of different length.
  float3 current = position(0, guide);
  float3 previous = g_state[guideIndex(1, 0, guide)].xyz;
  precise float share = g_vspCoefficient;
  if (isUsable(current) && isUsable(previous)) {
    precise float stepBefore = g_timeStep / g_timeStepRatio;
    precise float3 velocity = (end.position - current) / g_timeStep;
    precise float3 velocityBefore = (current - previous) / stepBefore;
    precise float3 change = (velocity - velocityBefore) * (2.0 / (g_timeStep + stepBefore));
    precise float acceleration = squareRoot(dot3(change, change));
    precise float excess = saturate(acceleration / g_vspThreshold - 1.0);
    // Smooth at both ends, so that no frame switches.
    precise float ramp = excess * excess * (3.0 - 2.0 * excess);
    share = share + (1.0 - share) * ramp;
  }
  share = saturate(share);
  float4 turn = normalizeQuaternion(multiplyQuaternions(end.rotation, conjugate(begin.rotation)));
  motion.rotation = interpolateQuaternions(float4(0.0, 0.0, 0.0, 1.0), turn, share);
  precise float3 shift = (end.position - begin.position) * share;
  motion.shift = shift;
#endif
  return motion;
}

// ---- free motion

struct Particle {
  float3 goal;      // bind position in the end pose
  float3 stored;    // position at the begin of the sub-step
  float3 current;   // the same, carried by the root's motion
  float3 previous;  // one sub-step earlier, carried likewise
  bool held;        // by its inverse mass
  bool free;        // neither held nor lost: else it goes to its goal
};

Particle loadParticle(uint vertex, uint guide, float3 bindRoot, RootPose end, Motion motion) {
  Particle p;
  p.goal = goalPosition(end, bindRoot, restPosition(vertex, guide));
  p.stored = position(vertex, guide);
  p.previous = g_state[guideIndex(1, vertex, guide)].xyz;
  bool lost = (g_flags & 1u) != 0u || !isUsable(p.stored) || !isUsable(p.previous);
  if (lost) {
    p.stored = p.goal;
    p.current = p.goal;
    p.previous = p.goal;
  } else {
    p.current = carried(motion, p.stored);
    p.previous = carried(motion, p.previous);
  }
  p.held = inverseMass(vertex, guide) <= 0.0;
  p.free = !lost && !p.held;
  return p;
}

// v, no longer than the limit, in the same direction; 0 where it overflowed.
float3 limited(float3 v, float limit) {
  if (!isUsable(v)) return float3(0.0, 0.0, 0.0);
  precise float squared = dot3(v, v);
  precise float most = limit * limit;
  if (!(squared > most)) return v;
  precise float3 r = directionOr(v, float3(0.0, 0.0, 0.0)) * limit;
  return r;
}

// Returns the last held vertex.
uint integrate(uint guide, float3 bindRoot, RootPose end, Motion motion) {
  precise float velocityFactor = g_timeStepRatio * g_dampingKeep;
  precise float3 fall = g_gravity.xyz * g_gravityStep;
#if WIND
  precise float dragStep = g_wind.w * g_timeStep;
  precise float dragShare = dragStep / (1.0 + dragStep);
  precise float3 windStep = g_wind.xyz * g_timeStep;
#endif
  Particle p = loadParticle(0, guide, bindRoot, end, motion);
  float3 before = p.current;
  uint held = 1;
  for (uint i = 0; i < g_vertexCount; ++i) {
    Particle next = p;
    if (i + 1 < g_vertexCount) next = loadParticle(i + 1, guide, bindRoot, end, motion);
    float3 moved = p.goal;
    float3 history = p.stored;
    if (p.free) {
      precise float3 u = (p.current - p.previous) * velocityFactor + fall;
#if WIND
      float3 tangent = directionOr(next.current - before, float3(0.0, 0.0, 0.0));
      precise float3 relative = windStep - u;
      precise float3 across = relative - tangent * dot3(tangent, relative);
      u = u + across * dragShare;
#endif
      precise float maxStep = g_maxSpeed * g_timeStep;
      u = limited(u, maxStep);
      precise float3 x = p.current + u;
#if GLOBAL_SHAPE
      precise float rangeEnd = g_globalRange * float(g_vertexCount);
      if (float(i) < rangeEnd) x = x + (p.goal - x) * g_globalStiffness;
#endif
      moved = x;
      history = p.current;
    } else if (p.held) {
      held = i;
    }
    setPosition(i, guide, moved);
    g_state[guideIndex(1, i, guide)] = float4(history, 0.0);
    before = p.current;
    p = next;
  }
  return max(held, 1);
}

// ---- local shape

// What rounding alone may change the length of a segment at p by: coordinates have an error of
// 6e-8 of their size at each of a few roundings, and the arm from the root is at most as long as p
// and the root are far from the origin. Errors below it are left alone: corrections of that size
// would be rounded again, step after step, and a resting strand would wander.
float lengthRounding(float3 p, float3 root) {
  precise float r = 2.4e-7 * (max(abs(p.x), max(abs(p.y), abs(p.z))) +
                              max(abs(root.x), max(abs(root.y), abs(root.z))));
  return r;
}

// Direction of a segment for the transport of frames. Coordinates around p have an error of about
// 1e-7 |p|; where the segment is hardly longer than that, its measured direction is noise, and the
// rest vector takes over. Without this a segment below a micrometre turns the whole strand behind.
float3 transportDirection(float3 segment, float3 expected, float rest, float3 p, float3 before) {
  precise float noise = 1e-6 * (abs(p.x) + abs(p.y) + abs(p.z));
  precise float share = noise * noise / max(rest, max(noise, 1e-20));
  precise float3 guess = directionOr(expected, before) * share;
  precise float3 sum = segment + guess;
  return directionOr(sum, before);
}

void keepLocalShape(uint guide, float4 rootFrame, float3 rootDirection) {
  uint rounds = min(g_localIterations, kMaxIterations);
  precise float share = 0.5 * g_localStiffness;
  float3 root = position(0, guide);
  for (uint round = 0; round < rounds; ++round) {
    float4 frame = rootFrame;
    float3 direction = rootDirection;
    float3 p = position(1, guide);
    float mass = 0.0;
    for (uint i = 1; i + 1 < g_vertexCount; ++i) {
      float4 rest = g_rest[guideIndex(1, i, guide)];
      float3 q = position(i + 1, guide);
      float massQ = inverseMass(i + 1, guide);
      float3 expected = rotate(frame, rest.xyz);
      precise float3 gap = expected + p - q;
      precise float rounding = 2.0 * lengthRounding(q, root);
      precise float3 correction = gap * share;
      if (max(abs(gap.x), max(abs(gap.y), abs(gap.z))) <= rounding)
        correction = float3(0.0, 0.0, 0.0);
      precise float3 newP = p - correction * mass;
      precise float3 newQ = q + correction * massQ;
      setPosition(i, guide, newP);
      precise float3 segment = newQ - newP;
      float3 turned = transportDirection(segment, expected, rest.w, newQ, direction);
      frame = normalizeQuaternion(multiplyQuaternions(rotationBetween(direction, turned), frame));
      direction = turned;
      p = newQ;
      mass = massQ;
    }
    setPosition(g_vertexCount - 1, guide, p);
  }
}

// ---- length

// One Newton step on C_j = |x_j+1 - x_j| - l_j = 0 for all segments j >= 1 at once: with n_j the
// directions and w_i the inverse masses, (J W J^T) lambda = -C has w_j + w_j+1 on its diagonal and
// -w_j+1 n_j.n_j+1 beside it (Goldenthal et al., "Efficient Simulation of Inextensible Cloth", ACM
// Trans. Graph. 26(3), 2007, equation 12, on a chain). Thomas' elimination from root to tip; the
// state's w components keep 1 / pivot and the reduced right-hand side. A segment without a
// direction is left to follow the leader.
void newtonLengthStep(uint guide) {
  float3 none = float3(0.0, 0.0, 0.0);
  float3 root = position(0, guide);
  float3 p = position(1, guide);
  float mass = 0.0;
  float3 directionBefore = none;
  precise float inversePivotBefore = 0.0;
  precise float sideBefore = 0.0;
  for (uint i = 1; i + 1 < g_vertexCount; ++i) {
    float3 q = position(i + 1, guide);
    float massQ = inverseMass(i + 1, guide);
    precise float3 segment = q - p;
    float3 direction = directionOr(segment, none);
    precise float error = dot3(direction, segment) - restLength(i, guide);
    if (abs(error) <= lengthRounding(q, root)) error = 0.0;
    precise float diagonal = mass + massQ;
    precise float coupling = -mass * dot3(directionBefore, direction);
    precise float pivot =
        max(diagonal - coupling * coupling * inversePivotBefore, diagonal * kLeastPivot);
    precise float inversePivot = diagonal > 0.0 ? 1.0 / pivot : 0.0;
    precise float side = -error - coupling * inversePivotBefore * sideBefore;
    g_state[guideIndex(0, i, guide)] = float4(p, inversePivot);
    g_state[guideIndex(1, i, guide)].w = side;
    directionBefore = direction;
    inversePivotBefore = inversePivot;
    sideBefore = side;
    p = q;
    mass = massQ;
  }

  float3 q = p;
  float massQ = mass;
  float3 directionAfter = none;
  precise float lambdaAfter = 0.0;
  precise float3 pushAfter = none;
  for (uint k = 1; k + 1 < g_vertexCount; ++k) {
    uint j = g_vertexCount - 1 - k;
    float4 atP = g_state[guideIndex(0, j, guide)];
    float side = g_state[guideIndex(1, j, guide)].w;
    precise float3 segment = q - atP.xyz;
    float3 direction = directionOr(segment, none);
    precise float coupling = -massQ * dot3(direction, directionAfter);
    precise float lambda = (side - coupling * lambdaAfter) * atP.w;
    precise float3 push = direction * lambda;
    precise float3 newQ = q + (push - pushAfter) * massQ;
    setPosition(j + 1, guide, newQ);
    q = atP.xyz;
    massQ = inverseMass(j, guide);
    directionAfter = direction;
    lambdaAfter = lambda;
    pushAfter = push;
  }
}

// The vertices between two held ones, a and b, that are `reach` metres of rest length apart. Too
// far apart: a straight line, all segments stretched alike. Else follow the leader from b and from
// a in turn (Aristidou and Lasenby, "FABRIK", Graphical Models 73(5), 2011), and what the last
// segment then lacks is spread over all of them.
void fitSpan(uint guide, uint a, uint b, float reach, float3 fallback) {
  float3 start = position(a, guide);
  float3 goal = position(b, guide);
  precise float3 whole = goal - start;
  float distance = squareRoot(dot3(whole, whole));
  precise float taut = reach * 0.999999;
  if (distance >= taut) {
    precise float done = 0.0;
    for (uint i = a + 1; i < b; ++i) {
      done = done + restLength(i - 1, guide);
      precise float share = reach > 0.0 ? done / reach : 0.0;
      precise float3 x = start + whole * share;
      setPosition(i, guide, x);
    }
    return;
  }
  for (uint round = 0; round < kSpanRounds; ++round) {
    precise float3 leader = goal;
    for (uint k = b - 1; k > a; --k) {
      precise float3 arm = position(k, guide) - leader;
      leader = leader + directionOr(arm, -fallback) * restLength(k, guide);
      setPosition(k, guide, leader);
    }
    leader = start;
    for (uint i = a + 1; i < b; ++i) {
      precise float3 arm = position(i, guide) - leader;
      leader = leader + directionOr(arm, fallback) * restLength(i - 1, guide);
      setPosition(i, guide, leader);
    }
  }
  precise float3 lastArm = goal - position(b - 1, guide);
  precise float3 lack = lastArm - directionOr(lastArm, fallback) * restLength(b - 1, guide);
  precise float along = 0.0;
  for (uint n = a + 1; n < b; ++n) {
    along = along + restLength(n - 1, guide);
    precise float share = along / reach;
    precise float3 x = position(n, guide) + lack * share;
    setPosition(n, guide, x);
  }
}

// Fits all spans; the free end behind the last held vertex follows its leader in finish().
void fitSpans(uint guide, float3 fallback) {
  uint held = 1;
  precise float reach = 0.0;
  for (uint i = 2; i < g_vertexCount; ++i) {
    reach = reach + restLength(i - 1, guide);
    if (inverseMass(i, guide) <= 0.0) {
      fitSpan(guide, held, i, reach, fallback);
      held = i;
      reach = 0.0;
    }
  }
}

// ---- output

void store(uint guide, uint vertex, float3 value, float3 tangent) {
  g_positions[vertexIndex(guide, vertex)] =
      float4(value, g_rest[guideIndex(0, vertex, guide)].w);
  g_tangents[vertexIndex(guide, vertex)] = float4(tangent, 0.0);
}

// Follow the leader beyond vertex `held` (g_vertexCount: nowhere), and the outputs. A vertex's
// tangent is the direction from the vertex before to the one after; at the two ends, that of the
// only segment.
void finish(uint guide, uint held, float3 fallback) {
  float3 root = position(0, guide);
  float3 beforeBefore = root;
  float3 before = root;
  float3 direction = fallback;
  for (uint i = 1; i < g_vertexCount; ++i) {
    precise float3 x = position(i, guide);
    precise float3 segment = x - before;
    direction = directionOr(segment, direction);
    if (i > held) {
      float rest = restLength(i - 1, guide);
      precise float error = dot3(direction, segment) - rest;
      if (!(abs(error) <= lengthRounding(x, root))) {
        x = before + direction * rest;
        setPosition(i, guide, x);
      }
    }
    precise float3 across = x - beforeBefore;
    store(guide, i - 1, before, directionOr(across, direction));
    beforeBefore = before;
    before = x;
  }
  store(guide, g_vertexCount - 1, before, direction);
}

[numthreads(64, 1, 1)]
void simulate_strands(uint3 thread : SV_DispatchThreadID) {
  uint guide = thread.x;
  if (guide >= g_guideCount) return;
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;

  float3 bindRoot = restPosition(0, guide);
  RootPose begin = rootPoseAt(guide, bindRoot, g_rootBegin);
  RootPose end = rootPoseAt(guide, bindRoot, g_rootEnd);
  float4 rootFrame = firstFrame(guide, end);
  float3 rootDirection = firstDirection(guide, bindRoot, end, rootFrame);

  uint held = integrate(guide, bindRoot, end, rootMotion(guide, begin, end));
  if ((g_flags & 1u) != 0u) {
    held = g_vertexCount;
  } else {
#if LOCAL_SHAPE
    keepLocalShape(guide, rootFrame, rootDirection);
#endif
    uint rounds = min(g_lengthIterations, kMaxIterations);
    for (uint round = 0; round < rounds; ++round) newtonLengthStep(guide);
    if (held > 1) fitSpans(guide, rootDirection);
  }
  finish(guide, held, rootDirection);
}
