// Writes the surface records.
//
// Threads: 4 a triangle, one for each of the records' first 4 elements, in rows of kRowGroups
//          groups of 64.
// Reads:   g_sdfPoints, g_sdfIndices, g_sdfNeighbors, g_sdfFanStarts, g_sdfFans; of bricks
//          g_sdfMarks
// Writes:  g_sdfSurface
//
// The normal of a vertex is the sum of the faces' unit normals times their angles at the vertex:
// with it, a point whose closest point is the vertex is outside if the direction to it has a
// positive part along the normal (Baerentzen and Aanaes, "Signed distance computation using the
// angle weighted pseudonormal", IEEE TVCG 11(3), 2005). It is gathered from the faces around the
// vertex, so its bits do not depend on the order of threads. A build of bricks writes only records
// at whose corners something moved, and the motion of all.
//
// Invariant (tests/sdf): as described in sdf.hlsli; normals within 0.01 degrees of double
// precision; the same bits from an incremental build.
#include "../base/octahedral.hlsli"
#include "sdf_bricks.hlsli"

// Angle between unit vectors [rad], within 1e-4: 2 atan(|a - b| / |a + b|), the arc tangent by
// Abramowitz and Stegun 4.4.49.
float angleBetween(float3 a, float3 b) {
  precise float3 apart = a - b;
  precise float3 together = a + b;
  precise float sine = squareRoot(dot3(apart, apart));
  precise float cosine = squareRoot(dot3(together, together));
  precise float most = max(sine, cosine);
  precise float t = min(sine, cosine) / max(most, 1e-6);
  precise float t2 = t * t;
  precise float series =
      0.9998660 + t2 * (-0.3302995 + t2 * (0.1801410 + t2 * (-0.0851330 + t2 * 0.0208351)));
  precise float angle = 2.0 * t * series;
  precise float r = sine > cosine ? 3.14159265 - angle : angle;
  return r;
}

// \param own  what stands in where the faces cancel
float3 normalAt(uint pointIndex, float3 own) {
  uint first = slotNow() * g_pointCount;
  float4 p = g_sdfPoints[first + pointIndex];
  precise float3 sum = float3(0.0, 0.0, 0.0);
  uint end = g_sdfFanStarts[pointIndex + 1u];
  for (uint i = g_sdfFanStarts[pointIndex]; i < end; ++i) {
    uint2 others = g_sdfFans[i];
    if (max(others.x, others.y) >= g_pointCount) continue;
    float4 next = g_sdfPoints[first + others.x];
    float4 last = g_sdfPoints[first + others.y];
    if (!(min(next.w, last.w) > 0.0)) continue;
    precise float3 a = next.xyz - p.xyz;
    precise float3 b = last.xyz - p.xyz;
    float3 none = float3(0.0, 0.0, 0.0);
    float3 along = directionOr(a, none);
    float3 back = directionOr(b, none);
    float3 face = directionOr(cross3(along, back), none);
    sum = sum + face * angleBetween(along, back);
  }
  return dot3(sum, sum) > 1e-8 ? sum : own;
}

// Displacement of a corner since the last build.
uint4 motionOf(uint pointIndex) {
  float4 now = g_sdfPoints[slotNow() * g_pointCount + pointIndex];
  float4 before = g_sdfPoints[slotBefore() * g_pointCount + pointIndex];
  precise float3 displacement = now.xyz - (before.xyz + g_historyShift.xyz);
  bool known = g_historyShift.w > 0.0 && min(now.w, before.w) > 0.0;
  uint4 bits = uint4(asuint(displacement), 0u);
  uint4 none = uint4(0u, 0u, 0u, 0u);
  return known ? bits : none;
}

[numthreads(64, 1, 1)]
void update_surface(uint3 group : SV_GroupID, uint thread : SV_GroupIndex) {
  uint index = indexOfGroup(group) * kSurfaceTriangles + thread / 4u;
  uint row = thread % 4u;
  if (index >= g_sdfTriangleCount) return;
  uint element = g_contactSdfSurface + index * g_sdfSurfaceStride;
  uint3 points =
      uint3(g_sdfIndices[3u * index], g_sdfIndices[3u * index + 1u], g_sdfIndices[3u * index + 2u]);
  PointTriangle t = loadTriangle(index, slotNow());
  uint pointIndex = row == 0u ? points.x : (row == 1u ? points.y : points.z);
  if (g_sdfSurfaceStride > 4u && row < 3u) {
    uint4 motion = uint4(0u, 0u, 0u, 0u);
    if (t.usable) motion = motionOf(pointIndex);
    g_sdfSurface[element + 4u + row] = motion;
  }
  uint marks = pointMarks();
  bool touched = !isOfBricks();
  if (!touched && max(points.x, max(points.y, points.z)) < g_pointCount)
    touched = g_sdfMarks[marks + points.x] == g_buildStamp ||
              g_sdfMarks[marks + points.y] == g_buildStamp ||
              g_sdfMarks[marks + points.z] == g_buildStamp;
  if (!touched) return;
  TriangleShape shape = shapeOf(t.a, t.b, t.c);
  bool counts = t.usable && shape.hasArea;
  uint4 record;
  if (row == 3u) {
    record = uint4(g_sdfNeighbors[3u * index], g_sdfNeighbors[3u * index + 1u],
                   g_sdfNeighbors[3u * index + 2u], 0u);
  } else if (counts) {
    float3 corner = row == 0u ? t.a : (row == 1u ? t.b : t.c);
    record = uint4(asuint(corner), packDirection(normalAt(pointIndex, shape.normal)));
  } else {
    float3 nowhere = float3(kSdfNowhere, kSdfNowhere, kSdfNowhere);
    record = uint4(asuint(nowhere), packDirection(float3(0.0, 0.0, 1.0)));
  }
  g_sdfSurface[element + row] = record;
}
