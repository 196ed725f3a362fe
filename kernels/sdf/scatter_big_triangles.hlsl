// Does the work of scatter_triangles for the triangles that it left out.
//
// Threads: 64 per brick of 4^3 nodes; dispatchIndirect, groups in x share the triangles, groups in
//          y share the bricks and the lines of one triangle.
// Reads:   g_sdfWork, g_sdfPoints, g_sdfIndices; of bricks g_sdfMarks
// Writes:  g_sdfKeys, g_sdfCounts
//
// A brick is skipped if it is further from the triangle's plane than the band: most bricks of a
// giant triangle that crosses the whole grid are.
//
// Invariant (tests/sdf): the same keys as if scatter_triangles had processed the triangle.
#include "sdf_bricks.hlsli"
#include "sdf_crossings.hlsli"

[numthreads(64, 1, 1)]
void scatter_big_triangles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = min(g_sdfWork[kWorkBigCount], g_sdfTriangleCount);
  bool ofBricks = isOfBricks();
  uint shares = max(g_sdfWork[kWorkBig + 1], 1u);
  for (uint entry = group.x; entry < count; entry += kBigGroups) {
    uint index = g_sdfWork[kWorkBigList + entry];
    if (index >= g_sdfTriangleCount) continue;
    PointTriangle t = loadTriangle(index, slotNow());
    if (!t.usable) continue;
    if (!ofBricks) addCrossings(t, 1, group.y * 64u + lane, shares * 64u);
    TriangleShape shape = shapeOf(t.a, t.b, t.c);
    NodeRange range = rangeOf(t);
    if (!shape.hasArea || isEmpty(range)) continue;
    float inverseLength = squareRoot(shape.inverseNormal);
    BrickRange bricks = bricksOf(range);
    uint most = bricks.extent.x * bricks.extent.y * bricks.extent.z;
    int3 corner = int3(int(lane & 3u), int((lane >> 2) & 3u), int(lane >> 4));
    for (uint i = group.y; i < most; i += shares) {
      uint3 brick = brickOf(bricks, i);
      if (ofBricks && g_sdfMarks[brickIndex(brick)] != g_buildStamp) continue;
      if (!isNearPlane(brick, shape, inverseLength)) continue;
      int3 low = int3(brick * 4u);
      int3 node = low + corner;
      if (min(min(node.x - range.low.x, node.y - range.low.y), node.z - range.low.z) < 0) continue;
      if (min(min(range.high.x - node.x, range.high.y - node.y), range.high.z - node.z) < 0)
        continue;
      scatterNode(node, index, shape);
    }
  }
}
