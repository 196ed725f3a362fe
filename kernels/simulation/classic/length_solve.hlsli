// Tensions and lengths of all segments at once, and the spans between held vertices.
#ifndef PELAGE_SIMULATION_CLASSIC_LENGTH_SOLVE_HLSLI
#define PELAGE_SIMULATION_CLASSIC_LENGTH_SOLVE_HLSLI

#include "strand_memory.hlsli"

// Passes over a span between two held vertices: with these, nearly taut spans of 11 segments under
// gravity and wind are stretched by at most 0.35 %.
static const uint kSpanRounds = 16;
// A pivot of the length solve below this share of its diagonal means a folded strand, whose
// segments depend on each other; without the floor one step may leave the float range.
static const float kMinPivot = 1e-4;

// A force density above it is that of a segment without a length.
static const float kMostDensity = 1e9;

// 1. Tensions. The step begins at X, where lengths are right, and the free motion leads to Y. Let
// d_j = X_j+1 - X_j, and q_j the force density of segment j, tension over length, times h^2 (Schek,
// "The force density method for form finding and computation of general networks", Comput. Methods
// Appl. Mech. Eng. 3(1), 1974). First, the tensions that keep the lengths to first order, along the
// segments as they are at X: J W J^T (q |d|) = J (Y - X). Then, with the segments' directions at
// the end, implicitly: x_i + q_i-1 (x_i - x_i-1) + q_i (x_i - x_i+1) = Y_i where vertex i is free.
// In displacements u = x - X, with q of compressed segments on the right side alone, because they
// would make the matrix indefinite:
//   u_i + q+_i-1 (u_i - u_i-1) + q+_i (u_i - u_i+1) = Y_i - X_i - q_i-1 d_i-1 + q_i d_i
// Both systems are tridiagonal and diagonally dominant. Where the forces of the free motion are
// balanced by tensions along the segments, the right side is 0: a strand at rest stays, whatever
// the size of the step. Tensions along directions that are not implicit let taut strands tremble,
// and so do a few Newton steps alone: in 1/60 s the weight of 64 vertices moves them by 57
// segments.
//
// 2. Newton steps on C_j = |d_j| - l_j = 0 for all segments j >= 1 at once, d_j = x_j+1 - x_j: with
// n_j = d_j / |d_j| and w_i the inverse masses, (J W J^T) lambda = -C has w_j + w_j+1 on its
// diagonal and -w_j+1 n_j.n_j+1 beside it (Goldenthal et al., "Efficient Simulation of Inextensible
// Cloth", ACM Trans. Graph. 26(3), 2007, equation 12, on a chain). Thomas' elimination: of segment
// j, after the one before it,
//   coupling c_j = -w n.n_j,  pivot p_j = diagonal - c_j^2 / p,  side s_j = -C_j - c_j s / p.
// Because the vertices move by w d_j mu_j, the back-substitution only needs
// mu_j = lambda_j / |d_j|:
//   mu_j = s_j / (p_j |d_j|) + w (d_j . d) mu / (p_j |d_j|^2)
// with d and mu of the segment that came after j in the elimination. So the elimination leaves two
// numbers per segment, and the back-substitution has no roots. The matrix is symmetric: it can be
// eliminated from either end, and the back-substitution of one step is the elimination of the next
// one. A segment without a direction is left to follow the leader.

// The elimination after the segments that it has passed.
struct LengthElimination {
  float3 d;       // of the last one
  float inverse;  // 1 / |d|
  float pivotInverse;
  float side;
  float3 root;  // of the strand, for the rounding of lengths
};

LengthElimination emptyElimination(float3 root) {
  LengthElimination e;
  e.d = float3(0.0, 0.0, 0.0);
  e.inverse = 0.0;
  e.pivotInverse = 0.0;
  e.side = 0.0;
  e.root = root;
  return e;
}

// Passes the segment from vertex a to b, whose length is `more` short in addition to what the two
// positions give. Returns s / (p |d|) and 1 / (p |d|^2).
float2 eliminateSegment(inout LengthElimination e, float3 a, float massA, float3 b, float massB,
                        float3 more, float rest) {
  precise float3 d = b - a;
  precise float squared = dot3(d, d);
  // Positive floats order like their bits: 1e-24 < squared < 1e38; a NaN is above.
  uint bits = asuint(squared);
  bool hasDirection = bits > 0x179abe15u && bits < 0x7e967699u;
  float root1 = inverseRoot(squared);
  precise float inverse = hasDirection ? root1 : 0.0;
  precise float excess = squared * inverse - rest;
  precise float error = abs(excess) > lengthRounding(b, e.root) ? excess : 0.0;
  error = error + dot3(more, d) * inverse;
  precise float diagonal = massA + massB;
  precise float coupling = -massA * (dot3(e.d, d) * e.inverse * inverse);
  precise float share = coupling * e.pivotInverse;
  precise float pivot = max(diagonal - coupling * share, diagonal * kMinPivot);
  precise float pivotOne = 1.0 / pivot;
  float pivotInverse = diagonal > 0.0 ? pivotOne : 0.0;
  precise float side = -error - share * e.side;
  precise float scale = pivotInverse * inverse;
  precise float2 result = float2(side * scale, scale * inverse);
  e.d = d;
  e.inverse = inverse;
  e.pivotInverse = pivotInverse;
  e.side = side;
  return result;
}

// A sweep over all segments from the root to the tip or back. `solve`: the back-substitution of the
// elimination that ran in the other direction. `eliminate`: the elimination of the next step, one
// segment behind. The vertex and the numbers that belong to a segment are stored at its end towards
// the root.
void sweepLengths(Strand s, bool toTip, bool solve, bool eliminate) {
  uint tip = g_vertexCount - 1;
  if (tip < 2) return;
  uint a = toTip ? 1 : tip;
  uint first = toTip ? 2 : tip - 1;
  float4 pointA = loadPoint(s, a);
  float2 lengthA = loadLength(s, a);
  float4 pointB = loadPoint(s, first);
  float2 lengthB = loadLength(s, first);
  float3 dBefore = float3(0.0, 0.0, 0.0);
  precise float mu = 0.0;
  precise float3 push = float3(0.0, 0.0, 0.0);
  // The vertex and the segment that the elimination comes from.
  float3 last = float3(0.0, 0.0, 0.0);
  float2 lengthLast = lengthA;
  LengthElimination e = emptyElimination(s.root);
  float restBefore = 0.0;
  float3 none = float3(0.0, 0.0, 0.0);
  for (uint k = 1; k < tip; ++k) {
    uint b = toTip ? k + 1 : tip - k;
    uint ahead = toTip ? min(k + 2, tip) : max(tip - k, 2) - 1;
    float4 pointAhead = loadPoint(s, ahead);
    float2 lengthAhead = loadLength(s, ahead);
    float massA = inverseMass(lengthA);
    float3 x = pointA.xyz;
    if (solve) {
      float side = toTip ? pointA.w : pointB.w;
      float ratio = toTip ? lengthA.x : lengthB.x;
      precise float3 d = pointB.xyz - pointA.xyz;
      mu = side + (massA * ratio) * dot3(dBefore, d) * mu;
      precise float3 pushHere = d * mu;
      precise float3 moved = pointA.xyz + (push - pushHere) * massA;
      x = moved;
      push = pushHere;
      dBefore = d;
    }
    // The segment before this one lies between `last` and a; before the first one, it has no length
    // and leaves nothing.
    float3 from = k > 1 ? last : x;
    float2 left = float2(0.0, 0.0);
    if (eliminate)
      left = eliminateSegment(e, from, inverseMass(lengthLast), x, massA, none, restBefore);
    float3 kept = toTip ? from : x;
    float held = toTip ? lengthLast.y : lengthA.y;
    uint slot = toTip ? max(a, 2) - 1 : a;
    storePoint(s, slot, float4(kept, left.x));
    storeLength(s, slot, float2(left.y, held));
    last = x;
    lengthLast = lengthA;
    restBefore = restLength(toTip ? lengthA : lengthB);
    a = b;
    pointA = pointB;
    lengthA = lengthB;
    pointB = pointAhead;
    lengthB = lengthAhead;
  }
  // Vertex a is the last one.
  float massEnd = inverseMass(lengthA);
  precise float3 end = pointA.xyz + push * massEnd;
  float2 left = float2(0.0, 0.0);
  if (eliminate)
    left = eliminateSegment(e, last, inverseMass(lengthLast), end, massEnd, none, restBefore);
  if (toTip) {
    storePoint(s, tip - 1, float4(last, left.x));
    storeLength(s, tip - 1, float2(left.y, lengthLast.y));
    storePoint(s, tip, float4(end, 0.0));
  } else {
    storePoint(s, 1, float4(end, left.x));
    storeLength(s, 1, float2(left.y, lengthA.y));
  }
}

// The first system of 1., eliminated from the root: leaves two numbers a segment as
// eliminateSegment() returns them.
void eliminateTensions(Strand s) {
  uint tip = g_vertexCount - 1;
  float4 pointA = loadPoint(s, 1);
  float3 beginA = beginning(s, 1);
  float2 lengthA = loadLength(s, 1);
  LengthElimination e = emptyElimination(s.root);
  for (uint a = 1; a < tip; ++a) {
    float4 pointB = loadPoint(s, a + 1);
    float3 beginB = beginning(s, a + 1);
    float2 lengthB = loadLength(s, a + 1);
    precise float3 more = (pointB.xyz - beginB) - (pointA.xyz - beginA);
    float2 left = eliminateSegment(e, beginA, inverseMass(lengthA), beginB, inverseMass(lengthB),
                                   more, restLength(lengthA));
    storePoint(s, a, float4(pointA.xyz, left.x));
    storeLength(s, a, float2(left.y, lengthA.y));
    pointA = pointB;
    beginA = beginB;
    lengthA = lengthB;
  }
}

// Back to the root: the force densities of the first system, and with them the elimination of the
// second one, which leaves u_i = xyz + w u_i-1.
void eliminateDisplacements(Strand s) {
  uint tip = g_vertexCount - 1;
  float4 pointB = loadPoint(s, tip);
  float3 beginB = beginning(s, tip);
  float massB = inverseMass(loadLength(s, tip));
  // Values of the segment and the vertex towards the tip.
  float3 dAhead = float3(0.0, 0.0, 0.0);
  precise float mu = 0.0;
  precise float3 pullAhead = float3(0.0, 0.0, 0.0);
  precise float3 pushAhead = float3(0.0, 0.0, 0.0);
  precise float stiffnessAhead = 0.0;
  for (uint b = tip; b > 1; --b) {
    float4 pointA = loadPoint(s, b - 1);
    float3 beginA = beginning(s, b - 1);
    float2 lengthA = loadLength(s, b - 1);
    precise float3 d = beginB - beginA;
    mu = pointA.w + (massB * lengthA.x) * dot3(dAhead, d) * mu;
    mu = abs(mu) < kMostDensity ? mu : 0.0;
    precise float tension = max(-mu, 0.0);
    precise float3 pull = d * -mu;
    precise float3 displacement = pointB.xyz - beginB;
    precise float3 side = displacement - pull + pullAhead + pushAhead;
    precise float rest = 1.0 + stiffnessAhead;
    precise float inverse = 1.0 / (rest + tension);
    precise float3 solved = side * inverse;
    bool free = massB > 0.0;
    float3 own = free ? solved : displacement;
    precise float share = free ? tension * inverse : 0.0;
    storePoint(s, b, float4(own, share));
    // The remaining terms of vertex b in the row of a.
    precise float3 push = own * tension;
    pushAhead = push;
    precise float stiffness = free ? tension * (rest * inverse) : tension;
    stiffnessAhead = stiffness;
    pullAhead = pull;
    dAhead = d;
    pointB = pointA;
    beginB = beginA;
    massB = inverseMass(lengthA);
  }
}

void moveByDisplacements(Strand s) {
  precise float3 u = position(s, 1) - beginning(s, 1);
  for (uint i = 2; i < g_vertexCount; ++i) {
    float4 left = loadPoint(s, i);
    precise float3 here = left.xyz + u * left.w;
    u = here;
    precise float3 x = beginning(s, i) + u;
    storePoint(s, i, float4(x, 0.0));
  }
}

void solveLengths(Strand s) {
  if (g_lengthIterations == 0 || g_vertexCount < 3) return;
  eliminateTensions(s);
  eliminateDisplacements(s);
  moveByDisplacements(s);
  uint rounds = min(g_lengthIterations - 1, kMaxIterations);
  if (rounds == 0) return;
  sweepLengths(s, true, false, true);
  for (uint round = 1; round < rounds; ++round) sweepLengths(s, (round & 1u) == 0u, true, true);
  sweepLengths(s, (rounds & 1u) == 0u, true, false);
}

// Fits the vertices between two held ones, a and b, that are `range` meters of rest length apart.
// If they are too far apart: a straight line, all segments stretched equally. Otherwise follow the
// leader from b and from a in turn (Aristidou and Lasenby, "FABRIK", Graphical Models 73(5), 2011);
// the length that the last segment then lacks is distributed over all of them.
void fitSpan(Strand s, uint a, uint b, float range, float3 fallback) {
  float3 start = position(s, a);
  float3 target = position(s, b);
  precise float3 whole = target - start;
  float distance = squareRoot(dot3(whole, whole));
  precise float taut = range * 0.999999;
  if (distance >= taut) {
    precise float done = 0.0;
    for (uint i = a + 1; i < b; ++i) {
      done = done + segmentLength(s, i - 1);
      precise float share = range > 0.0 ? done / range : 0.0;
      precise float3 x = start + whole * share;
      storePoint(s, i, float4(x, 1.0));
    }
    return;
  }
  for (uint round = 0; round < kSpanRounds; ++round) {
    precise float3 leader = target;
    for (uint k = b - 1; k > a; --k) {
      precise float3 arm = position(s, k) - leader;
      leader = leader + directionOr(arm, -fallback) * segmentLength(s, k);
      storePoint(s, k, float4(leader, 1.0));
    }
    leader = start;
    for (uint i = a + 1; i < b; ++i) {
      precise float3 arm = position(s, i) - leader;
      leader = leader + directionOr(arm, fallback) * segmentLength(s, i - 1);
      storePoint(s, i, float4(leader, 1.0));
    }
  }
  precise float3 lastArm = target - position(s, b - 1);
  precise float3 lack = lastArm - directionOr(lastArm, fallback) * segmentLength(s, b - 1);
  precise float along = 0.0;
  for (uint n = a + 1; n < b; ++n) {
    along = along + segmentLength(s, n - 1);
    precise float share = along / range;
    precise float3 x = position(s, n) + lack * share;
    storePoint(s, n, float4(x, 1.0));
  }
}

// Fits all spans; the free end behind the last held vertex follows its leader.
void fitSpans(Strand s, float3 fallback) {
  uint held = 1;
  precise float range = 0.0;
  for (uint i = 2; i <= s.held; ++i) {
    range = range + segmentLength(s, i - 1);
    if (inverseMass(loadLength(s, i)) <= 0.0) {
      fitSpan(s, held, i, range, fallback);
      held = i;
      range = 0.0;
    }
  }
}

#endif
