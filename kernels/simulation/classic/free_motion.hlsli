// Free motion of a strand's vertices in a step of H: inertia, gravity, wind, global shape.
#ifndef PELAGE_SIMULATION_CLASSIC_FREE_MOTION_HLSLI
#define PELAGE_SIMULATION_CLASSIC_FREE_MOTION_HLSLI

#include "../../base/random_hash.hlsli"
#include "strand_root.hlsli"

// h0, the shortest step for which forces are computed [s].
static const float kReferenceStep = 1.0 / 60.0;

float forceStep() { return max(g_timeStep, kReferenceStep); }

// A vertex as it is in memory.
struct StoredVertex {
  float4 bind;
  float rest;  // length of the segment behind it
  float3 current;
  float3 previous;
};

struct Particle {
  float rest;       // as stored
  float3 target;    // bind position in the end pose
  float3 stored;    // position at the start of the sub-step
  float3 current;   // the same, transported by the root's motion
  float3 previous;  // one sub-step earlier, transported likewise
  bool held;        // by its inverse mass
  bool free;        // neither held nor lost; otherwise it goes to its target
};

StoredVertex loadVertex(uint vertex, uint guide) {
  StoredVertex v;
  v.bind = g_rest[guideIndex(0, vertex, guide)];
  v.rest = g_rest[guideIndex(1, vertex, guide)].w;
  v.current = storedPosition(0, vertex, guide);
  v.previous = storedPosition(1, vertex, guide);
  return v;
}

Particle makeParticle(StoredVertex v, uint vertex, float3 bindRoot, RootPose end, Motion motion) {
  Particle p;
  p.rest = v.rest;
  p.target = targetPosition(end, bindRoot, v.bind.xyz);
  p.stored = v.current;
  p.previous = v.previous;
  bool lost = (g_flags & kResetFlag) != 0u || !isUsable(p.stored) || !isUsable(p.previous);
  float3 current = transported(motion, p.stored);
  float3 previous = transported(motion, p.previous);
  float3 target = p.target;
  p.stored = lost ? target : p.stored;
  p.current = lost ? target : current;
  p.previous = lost ? target : previous;
  p.held = vertex < 2 || !(v.bind.w > 0.0);
  p.free = !lost && !p.held;
  return p;
}

// Returns v, limited in length; 0 if it overflowed.
float3 limited(float3 v, float limit) {
  precise float squared = dot3(v, v);
  precise float most = limit * limit;
  bool usable = isUsable(v);
  float3 r = v;
  if (!(usable && squared <= most)) {
    float3 none = float3(0.0, 0.0, 0.0);
    precise float3 cut = directionOr(v, none) * limit;
    r = usable ? cut : none;
  }
  return r;
}

// Returns the displacement of the air in H. Every strand has its own phase of the gusts, which
// depends on its root.
float3 airDisplacement(float3 bindRoot) {
  precise float3 air = g_wind.xyz;
  if (g_gust0.w > 0.0) {
    uint seed = hashUints(asuint(bindRoot.x), hashUints(asuint(bindRoot.y), asuint(bindRoot.z)));
    precise float a = 2.0 * unitFloat(hashUint(seed)) - 1.0;
    precise float b = 2.0 * unitFloat(hashUint(seed + 1u)) - 1.0;
    float inverse = inverseRoot(max(a * a + b * b, 1e-12));
    precise float s0 = g_gust0.w * (a * inverse - 1.0);
    precise float s1 = g_gust0.w * (b * inverse);
    precise float3 varied = air + g_gust0.xyz * s0 + g_gust1.xyz * s1;
    air = varied;
  }
  precise float3 displacement = air * forceStep();
  return displacement;
}

// Moves the vertices to where a step of H takes them without the shape of the strand, and writes
// their history to g_state. Sets held vertices.
void integrate(inout Strand s, float3 bindRoot, RootPose end, Motion motion) {
  uint guide = s.guide;
  bool hasFactors = g_factorSet > 0;
  precise float keepAll = g_dampingKeep;
  precise float gravityAll = g_gravityStep;
  float stepLength = forceStep();
  precise float maxStep = g_maxSpeed * stepLength;
  precise float velocityRatio = g_timeStepRatio * (stepLength / g_timeStep);
  // Fraction of the inertia of H, beside the fraction of the change by forces; 0 if that is 1.
  precise float driftShare = g_timeStep / stepLength - g_forceShare;
  bool drags = g_wind.w > 0.0;
  precise float dragStep = g_wind.w * stepLength;
  precise float dragShare = dragStep / (1.0 + dragStep);
  float3 windStep = float3(0.0, 0.0, 0.0);
  if (drags) windStep = airDisplacement(bindRoot);
  bool hasTargets = g_globalStiffness > 0.0;
  precise float rangeEnd = g_globalRange * float(g_vertexCount);
  uint last = g_vertexCount - 1;
  Particle p = makeParticle(loadVertex(0, guide), 0, bindRoot, end, motion);
  // Loads two vertices ahead, to hide the latency of memory.
  StoredVertex ahead = loadVertex(1, guide);
  StoredVertex further = loadVertex(min(2, last), guide);
  float3 before = p.current;
  uint held = 1;
  for (uint i = 0; i <= last; ++i) {
    StoredVertex furthest = loadVertex(min(i + 3, last), guide);
    // The tip comes after itself.
    Particle next = makeParticle(ahead, i + 1, bindRoot, end, motion);
    ahead = further;
    further = furthest;
    float3 factors = float3(1.0, 1.0, 1.0);
    precise float keep = keepAll;
    precise float gravityStep = gravityAll;
    if (hasFactors) {
      factors = g_rest[guideIndex(2, i, guide)].xyz;
      // With the same gravityStep the terminal velocity falls as the damping rises.
      precise float lost = factors.z * (1.0 - keepAll);
      keep = 1.0 - min(lost, 1.0);
      gravityStep = gravityAll / max(lost, 1.0);
    }
    precise float velocityFactor = velocityRatio * keep;
    precise float3 u = (p.current - p.previous) * velocityFactor + g_gravity.xyz * gravityStep;
#if FORCES
    float4 force = g_strandForces[vertexIndex(guide, i)];
    if (isUsable(force)) {
      precise float drag = max(force.w, 0.0) * stepLength;
      precise float3 pushed = u + force.xyz * (1.0 - g_gravity.w) * stepLength * stepLength;
      u = pushed / (1.0 + drag);
    }
#endif
    if (drags) {
      float3 tangent = directionOr(next.current - before, float3(0.0, 0.0, 0.0));
      precise float3 relative = windStep - u;
      precise float3 across = relative - tangent * dot3(tangent, relative);
      u = u + across * dragShare;
    }
    u = limited(u, maxStep);
    precise float3 x = p.current + u;
    if (hasTargets) {
      float targetShare = g_globalStiffness;
      if (hasFactors) targetShare = scaledShare(g_globalStiffness, factors.y);
      float share = float(i) < rangeEnd ? targetShare : 0.0;
      x = x + (p.target - x) * share;
    }
    float3 target = p.target;
    float3 moved = p.free ? x : target;
    float3 stored = p.stored;
    float3 transportedNow = p.current;
    // The root's own history has its motion; that of the others is where the step starts.
    float3 history = i > 0 ? transportedNow : stored;
    held = p.held ? i : held;
    storePoint(s, i, float4(moved, p.held ? 0.0 : 1.0));
    storeLength(s, i, packLength(p.rest, p.held));
    g_state[guideIndex(1, i, guide)] = float4(history, 0.0);
    if (g_forceShare < 1.0) {
      precise float3 displacement = (p.current - p.previous) * velocityRatio;
      precise float3 drift = limited(displacement, maxStep) * driftShare;
      float3 none = float3(0.0, 0.0, 0.0);
      g_state[guideIndex(2, i, guide)] = float4(p.free ? drift : none, 0.0);
    }
    before = p.current;
    p = next;
  }
  s.held = max(held, 1);
}

// Goes from where the forces of a step of H take a strand to where those of h take it: the change
// of displacement by forces, times g_forceShare, in addition to the inertia. At rest there is no
// inertia, and the lengths undo any fraction of a change that they undo as a whole, so a strand
// rests in the same shape whatever h is. The result is a mean of three points: the position of the
// vertex, where its velocity takes it in H, and where a step of H takes it.
void takeForceShare(Strand s) {
  if (!(g_forceShare < 1.0)) return;
  for (uint i = 2; i < g_vertexCount; ++i) {
    float4 there = loadPoint(s, i);
    float3 begin = g_state[guideIndex(1, i, s.guide)].xyz;
    float3 drift = g_state[guideIndex(2, i, s.guide)].xyz;
    precise float3 x = begin + (drift + (there.xyz - begin) * g_forceShare);
    float3 moved = there.w > 0.0 ? x : there.xyz;
    storePoint(s, i, float4(moved, there.w));
  }
}

#endif
