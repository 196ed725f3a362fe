// Writes the surface records.
//
// Threads: 4 a triangle, one for each of the records' first 4 elements, in rows of kGroupsARow
//          groups of 64.
// Reads:   g_sdfPlaces, g_sdfIndices, g_sdfNeighbors, g_sdfFanStarts, g_sdfFans; of bricks
//          g_sdfMarks
// Writes:  g_sdfSurface
//
// The normal of a vertex is the sum of the faces' unit normals times their angles at the vertex:
// with it, a point whose closest point is the vertex is outside where the way to it goes along the
// normal (Baerentzen and Aanaes, "Signed distance computation using the angle weighted
// pseudonormal", IEEE TVCG 11(3), 2005). It is gathered from the faces around the vertex, so that
// its bits do not depend on the order of threads.
// A build of bricks: only records at whose corners something moved, and the motion of all.
//
// Invariant (tests/kernel): as sdf_field.hlsli says; normals within 0.01 degrees of double
// precision; the same bits from an incremental build.
#include "../common/octahedral.hlsli"
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
float3 normalAt(uint place, float3 own) {
  uint first = slotNow() * g_placeCount;
  float4 p = g_sdfPlaces[first + place];
  precise float3 sum = float3(0.0, 0.0, 0.0);
  uint end = g_sdfFanStarts[place + 1u];
  for (uint i = g_sdfFanStarts[place]; i < end; ++i) {
    uint2 others = g_sdfFans[i];
    if (max(others.x, others.y) >= g_placeCount) continue;
    float4 next = g_sdfPlaces[first + others.x];
    float4 last = g_sdfPlaces[first + others.y];
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

// Way of a corner since the last build.
uint4 motionOf(uint place) {
  float4 now = g_sdfPlaces[slotNow() * g_placeCount + place];
  float4 before = g_sdfPlaces[slotBefore() * g_placeCount + place];
  precise float3 way = now.xyz - (before.xyz + g_historyShift.xyz);
  bool known = g_historyShift.w > 0.0 && min(now.w, before.w) > 0.0;
  uint4 bits = uint4(asuint(way), 0u);
  uint4 none = uint4(0u, 0u, 0u, 0u);
  return known ? bits : none;
}

[numthreads(64, 1, 1)]
void update_surface(uint3 group : SV_GroupID, uint thread : SV_GroupIndex) {
  uint index = indexOfGroup(group) * 16u + thread / 4u;
  uint row = thread % 4u;
  if (index >= g_fieldTriangleCount) return;
  uint element = g_fieldSurface + index * g_fieldSurfaceStride;
  uint3 places = uint3(g_sdfIndices[3u * index], g_sdfIndices[3u * index + 1u],
                       g_sdfIndices[3u * index + 2u]);
  PlacedTriangle t = loadTriangle(index, slotNow());
  uint place = row == 0u ? places.x : (row == 1u ? places.y : places.z);
  if (g_fieldSurfaceStride > 4u && row < 3u) {
    uint4 motion = uint4(0u, 0u, 0u, 0u);
    if (t.usable) motion = motionOf(place);
    g_sdfSurface[element + 4u + row] = motion;
  }
  uint marks = placeMarks();
  bool touched = !isOfBricks();
  if (!touched && max(places.x, max(places.y, places.z)) < g_placeCount)
    touched = g_sdfMarks[marks + places.x] == g_buildStamp ||
              g_sdfMarks[marks + places.y] == g_buildStamp ||
              g_sdfMarks[marks + places.z] == g_buildStamp;
  if (!touched) return;
  TriangleShape shape = shapeOf(t.a, t.b, t.c);
  bool counts = t.usable && shape.hasArea;
  uint4 record;
  if (row == 3u) {
    record = uint4(g_sdfNeighbors[3u * index], g_sdfNeighbors[3u * index + 1u],
                   g_sdfNeighbors[3u * index + 2u], 0u);
  } else if (counts) {
    float3 corner = row == 0u ? t.a : (row == 1u ? t.b : t.c);
    record = uint4(asuint(corner), packDirection(normalAt(place, shape.normal)));
  } else {
    float3 nowhere = float3(kSdfNowhere, kSdfNowhere, kSdfNowhere);
    record = uint4(asuint(nowhere), packDirection(float3(0.0, 0.0, 1.0)));
  }
  g_sdfSurface[element + row] = record;
}
