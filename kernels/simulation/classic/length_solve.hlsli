// Lengths of all segments at once, and the spans between held vertices.
#ifndef PELAGE_SIMULATION_CLASSIC_LENGTH_SOLVE_HLSLI
#define PELAGE_SIMULATION_CLASSIC_LENGTH_SOLVE_HLSLI

#include "strand_memory.hlsli"

// Passes over a span between two held vertices: nearly taut spans of 11 segments under gravity and
// wind are then stretched by 0.35 % at worst.
static const uint kSpanRounds = 16;
// A pivot of the length solve below this share of its diagonal means a folded strand, whose
// segments depend on each other; without the floor one step may leave the float range.
static const float kLeastPivot = 1e-4;

// Newton steps on C_j = |d_j| - l_j = 0 for all segments j >= 1 at once, d_j = x_j+1 - x_j: with
// n_j = d_j / |d_j| and w_i the inverse masses, (J W J^T) lambda = -C has w_j + w_j+1 on its
// diagonal and -w_j+1 n_j.n_j+1 beside it (Goldenthal et al., "Efficient Simulation of Inextensible
// Cloth", ACM Trans. Graph. 26(3), 2007, equation 12, on a chain). Thomas' elimination: of segment
// j, after the one before it,
//   coupling c_j = -w n.n_j,  pivot p_j = diagonal - c_j^2 / p,  side s_j = -C_j - c_j s / p.
// The way back needs mu_j = lambda_j / |d_j| alone, because the vertices move by w d_j mu_j:
//   mu_j = s_j / (p_j |d_j|) + w (d_j . d) mu / (p_j |d_j|^2)
// with d and mu of the segment that came after j in the elimination. So the elimination leaves two
// numbers a segment, and there are no roots on the way back. The matrix is symmetric: it is
// eliminated from either end, and the way back of one step is the elimination of the next one.
// A segment without a direction is left to follow the leader.

// The elimination after the segments that it has passed.
struct LengthElimination {
  float3 d;       // of the last one
  float inverse;  // 1 / |d|
  float pivotInverse;
  float side;
};

LengthElimination emptyElimination() {
  LengthElimination e;
  e.d = float3(0.0, 0.0, 0.0);
  e.inverse = 0.0;
  e.pivotInverse = 0.0;
  e.side = 0.0;
  return e;
}

// Passes the segment from vertex a to b. Returns s / (p |d|) and 1 / (p |d|^2).
float2 eliminateSegment(inout LengthElimination e, float3 a, float massA, float3 b, float massB,
                        float rest, float3 root) {
  precise float3 d = b - a;
  precise float squared = dot3(d, d);
  // Positive floats order like their bits: 1e-24 < squared < 1e38; a NaN is above.
  uint bits = asuint(squared);
  bool hasDirection = bits > 0x179abe15u && bits < 0x7e967699u;
  float root1 = inverseRoot(squared);
  precise float inverse = hasDirection ? root1 : 0.0;
  precise float excess = squared * inverse - rest;
  float error = abs(excess) > lengthRounding(b, root) ? excess : 0.0;
  precise float diagonal = massA + massB;
  precise float coupling = -massA * (dot3(e.d, d) * e.inverse * inverse);
  precise float share = coupling * e.pivotInverse;
  precise float pivot = max(diagonal - coupling * share, diagonal * kLeastPivot);
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

// A sweep over all segments from the root to the tip or back. `solve`: the way back of the
// elimination that went the other way. `eliminate`: the elimination of the next step, one segment
// behind. Vertices and numbers that a segment leaves lie at its end towards the root.
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
  LengthElimination e = emptyElimination();
  float restBefore = 0.0;
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
      left = eliminateSegment(e, from, inverseMass(lengthLast), x, massA, restBefore, s.root);
    float3 kept = toTip ? from : x;
    float held = toTip ? lengthLast.y : lengthA.y;
    uint place = toTip ? max(a, 2) - 1 : a;
    storePoint(s, place, float4(kept, left.x));
    storeLength(s, place, float2(left.y, held));
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
    left = eliminateSegment(e, last, inverseMass(lengthLast), end, massEnd, restBefore, s.root);
  if (toTip) {
    storePoint(s, tip - 1, float4(last, left.x));
    storeLength(s, tip - 1, float2(left.y, lengthLast.y));
    storePoint(s, tip, float4(end, 0.0));
  } else {
    storePoint(s, 1, float4(end, left.x));
    storeLength(s, 1, float2(left.y, lengthA.y));
  }
}

void solveLengths(Strand s) {
  uint rounds = min(g_lengthIterations, kMaxIterations);
  if (rounds == 0) return;
  sweepLengths(s, true, false, true);
  for (uint round = 1; round < rounds; ++round) sweepLengths(s, (round & 1u) == 0u, true, true);
  sweepLengths(s, (rounds & 1u) == 0u, true, false);
}

// The vertices between two held ones, a and b, that are `reach` metres of rest length apart. Too
// far apart: a straight line, all segments stretched alike. Else follow the leader from b and from
// a in turn (Aristidou and Lasenby, "FABRIK", Graphical Models 73(5), 2011), and what the last
// segment then lacks is spread over all of them.
void fitSpan(Strand s, uint a, uint b, float reach, float3 fallback) {
  float3 start = position(s, a);
  float3 goal = position(s, b);
  precise float3 whole = goal - start;
  float distance = squareRoot(dot3(whole, whole));
  precise float taut = reach * 0.999999;
  if (distance >= taut) {
    precise float done = 0.0;
    for (uint i = a + 1; i < b; ++i) {
      done = done + segmentLength(s, i - 1);
      precise float share = reach > 0.0 ? done / reach : 0.0;
      precise float3 x = start + whole * share;
      storePoint(s, i, float4(x, 1.0));
    }
    return;
  }
  for (uint round = 0; round < kSpanRounds; ++round) {
    precise float3 leader = goal;
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
  precise float3 lastArm = goal - position(s, b - 1);
  precise float3 lack = lastArm - directionOr(lastArm, fallback) * segmentLength(s, b - 1);
  precise float along = 0.0;
  for (uint n = a + 1; n < b; ++n) {
    along = along + segmentLength(s, n - 1);
    precise float share = along / reach;
    precise float3 x = position(s, n) + lack * share;
    storePoint(s, n, float4(x, 1.0));
  }
}

// Fits all spans; the free end behind the last held vertex follows its leader.
void fitSpans(Strand s, float3 fallback) {
  uint held = 1;
  precise float reach = 0.0;
  for (uint i = 2; i <= s.held; ++i) {
    reach = reach + segmentLength(s, i - 1);
    if (inverseMass(loadLength(s, i)) <= 0.0) {
      fitSpan(s, held, i, reach, fallback);
      held = i;
      reach = 0.0;
    }
  }
}

#endif
