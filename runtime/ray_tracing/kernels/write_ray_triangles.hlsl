// Writes strands as disjoint orthogonal triangle strips: each segment is two quads through its axis,
// at right angles, as wide as the fiber. From any side, at least 0.7 of its width is covered.
//
// Threads: one a segment, in rows of 2^20.
// Reads:   g_rayStrands, g_rayThickness
// Writes:  g_rayPositions: eight vertices a segment, a quad behind the other; of a quad the root's
//          two, then the tip's
//
// Invariant (tests/ray_tracing): the bits are those of the same operations on a CPU.
#include "ray_strands.hlsli"

[numthreads(64, 1, 1)]
void write_ray_triangles(uint3 thread : SV_DispatchThreadID) {
  uint element = indexOfThread(thread);
  if (element >= g_rayElements) return;
  uint strand = element / g_raySegments;
  uint segment = element % g_raySegments;
  uint root = sourceVertex(segment), tip = sourceVertex(segment + 1u);
  float3 a = rayPosition(strand, root), b = rayPosition(strand, tip);
  float radiusA = rayRadius(strand, root), radiusB = rayRadius(strand, tip);
  precise float3 edge = b - a;
  float3 axis = directionOr(edge, float3(0.0, 1.0, 0.0));
  float3 side = perpendicular(axis);
  uint first = element * kRayTriangleVertices;
  for (uint quad = 0u; quad < 2u; ++quad) {
    precise float3 rootSide = side * radiusA;
    precise float3 tipSide = side * radiusB;
    precise float3 corner0 = a - rootSide;
    precise float3 corner1 = a + rootSide;
    precise float3 corner2 = b - tipSide;
    precise float3 corner3 = b + tipSide;
    writeRayPosition(first, corner0);
    writeRayPosition(first + 1u, corner1);
    writeRayPosition(first + 2u, corner2);
    writeRayPosition(first + 3u, corner3);
    first += 4u;
    side = cross3(axis, side);
  }
}
