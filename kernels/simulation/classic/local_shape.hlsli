// Local shape: segments move towards their rest vectors.
#ifndef PELAGE_SIMULATION_CLASSIC_LOCAL_SHAPE_HLSLI
#define PELAGE_SIMULATION_CLASSIC_LOCAL_SHAPE_HLSLI

#include "strand_memory.hlsli"

// A sweep from root to tip, before segment i: the frame and direction of the segment before.
struct ShapeSweep {
  float4 frame;
  float3 direction;
  float3 p;     // vertex i, final except for this segment
  float mass;   // of vertex i
  float share;  // fraction of the displacement to the rest vector that each end moves
};

// Returns the direction of a segment for the transport of frames. Coordinates around p have an
// error of about 1e-7 |p|; if the segment is hardly longer than that, its measured direction is
// noise, and the rest vector replaces it. Otherwise a segment below a micrometer would rotate the
// whole strand behind it.
float3 transportDirection(float3 segment, float3 expected, float rest, float3 p, float3 before) {
  precise float noise = 1e-6 * (abs(p.x) + abs(p.y) + abs(p.z));
  precise float share = noise * noise / max(rest, max(noise, 1e-20));
  // The rest vector is as long as the segment at rest.
  precise float3 scaled = expected * (1.0 / max(rest, 1e-12));
  float3 guess = rest >= 1e-12 ? scaled : before;
  precise float3 sum = segment + guess * share;
  return directionOr(sum, before);
}

// The segment from sweep.p to q. Returns the final position of its first vertex.
float3 sweepSegment(inout ShapeSweep sweep, float4 rest, float3 q, float massQ, float3 root) {
  float3 expected = rotate(sweep.frame, rest.xyz);
  precise float3 gap = expected + sweep.p - q;
  precise float rounding = 2.0 * lengthRounding(q, root);
  float act = max(abs(gap.x), max(abs(gap.y), abs(gap.z))) > rounding ? sweep.share : 0.0;
  precise float3 correction = gap * act;
  precise float3 newP = sweep.p - correction * sweep.mass;
  precise float3 newQ = q + correction * massQ;
  precise float3 segment = newQ - newP;
  float3 rotated = transportDirection(segment, expected, rest.w, newQ, sweep.direction);
  // rotationBetween() without its own normalization.
  float3 d = sweep.direction;
  precise float scalar = 1.0 + dot3(d, rotated);
  float4 between = float4(cross3(d, rotated), scalar);
  float3 flat = float3(-d.y, d.x, 0.0);
  float3 upright = float3(0.0, -d.z, d.y);
  float3 across = abs(d.x) + abs(d.y) < 0.1 ? upright : flat;
  float4 opposite = float4(across, 0.0);
  between = scalar < 1e-5 ? opposite : between;
  sweep.frame = normalizeQuaternion(multiplyQuaternions(between, sweep.frame));
  sweep.direction = rotated;
  sweep.p = newQ;
  sweep.mass = massQ;
  return newP;
}

// Returns the local stiffness of the segment that ends at a vertex, with its factor.
float shapeShare(float share, uint vertex, uint guide) {
  float r = share;
  if (g_factorSet > 0) {
    // Twice the share is the spring's; beyond 0.95 the sweeps overshoot.
    precise float scaled = scaledShare(2.0 * share, g_rest[guideIndex(2, vertex, guide)].x);
    precise float limited = 0.5 * min(scaled, 0.95);
    r = limited;
  }
  return r;
}

// Runs two sweeps at a time, the second one segment behind the first: they do not wait for each
// other.
void keepLocalShape(Strand s, float4 rootFrame, float3 rootDirection) {
  uint rounds = min(g_localIterations, kMaxIterations);
  uint last = g_vertexCount - 1;
  if (last < 2) return;
  for (uint round = 0; round < rounds; round += 2) {
    precise float share = 0.5 * g_localStiffness;
    ShapeSweep first;
    first.frame = rootFrame;
    first.direction = rootDirection;
    first.p = position(s, 1);
    first.mass = 0.0;
    first.share = share;
    ShapeSweep second = first;
    second.share = round + 1 < rounds ? share : 0.0;
    float4 restBefore = g_rest[guideIndex(1, 1, s.guide)];
    float4 rest = g_rest[guideIndex(1, 2, s.guide)];
    float4 q = loadPoint(s, min(3, last));
    float4 start = loadPoint(s, 2);
    // Vertex 1 stays.
    first.share = shapeShare(share, 2, s.guide);
    sweepSegment(first, restBefore, start.xyz, start.w, s.root);
    for (uint i = 2; i < last; ++i) {
      float4 restAhead = g_rest[guideIndex(1, i + 1, s.guide)];
      float4 ahead = loadPoint(s, min(i + 2, last));
      float mass = first.mass;
      float massBefore = second.mass;
      if (g_factorSet > 0) {
        second.share = second.share > 0.0 ? first.share : 0.0;
        first.share = shapeShare(share, i + 1, s.guide);
      }
      float3 p = sweepSegment(first, rest, q.xyz, q.w, s.root);
      float3 done = sweepSegment(second, restBefore, p, mass, s.root);
      storePoint(s, i - 1, float4(done, massBefore));
      restBefore = rest;
      rest = restAhead;
      q = ahead;
    }
    float massBefore = second.mass;
    if (g_factorSet > 0) second.share = second.share > 0.0 ? first.share : 0.0;
    float3 done = sweepSegment(second, restBefore, first.p, first.mass, s.root);
    storePoint(s, last - 1, float4(done, massBefore));
    storePoint(s, last, float4(second.p, second.mass));
  }
}

#endif
