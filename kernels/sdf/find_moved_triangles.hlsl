// Takes the crossings of triangles that moved from where they were to where they are, and clears
// the bricks that their bands reach, there and here.
//
// Threads: 16 a triangle, in rows of kGroupsARow groups of 64; dispatchIndirect.
// Reads:   g_sdfPlaces of this build and of the last one, g_sdfIndices
// Writes:  g_sdfCounts, g_sdfMarks, g_sdfKeys, g_sdfWork
//
// Who marks a brick first clears it: nobody else touches keys before scatter_triangles. The marks
// of places are those at which a normal changes.
//
// Invariant (tests/kernel): crossings are those of a build from an empty grid.
#include "sdf_bricks.hlsli"
#include "sdf_crossings.hlsli"

void clearBrick(uint3 brick) {
  uint3 low = brick * 4u;
  for (uint i = 0; i < 64; ++i) {
    uint3 node = low + uint3(i & 3u, (i >> 2) & 3u, i >> 4);
    if (node.y < g_fieldNodes.y && node.z < g_fieldNodes.z)
      g_sdfKeys[g_fieldNodes.w + nodeIndex(int3(node))] = kSdfUnset;
  }
}

void clearBricks(PlacedTriangle t, uint lane, uint lanes) {
  NodeRange range = rangeOf(t);
  if (!t.usable || isEmpty(range)) return;
  TriangleShape shape = shapeOf(t.a, t.b, t.c);
  if (!shape.hasArea) return;
  float inverseLength = squareRoot(shape.inverseNormal);
  BrickRange bricks = bricksOf(range);
  uint count = bricks.extent.x * bricks.extent.y * bricks.extent.z;
  for (uint i = lane; i < count; i += lanes) {
    uint3 brick = brickOf(bricks, i);
    if (!isNearPlane(brick, shape, inverseLength)) continue;
    uint last;
    InterlockedMax(g_sdfMarks[brickIndex(brick)], g_buildStamp, last);
    if (last == g_buildStamp) continue;
    clearBrick(brick);
    InterlockedAdd(g_sdfWork[kWorkBricks], 1u);
  }
}

bool differ(float3 a, float3 b) {
  uint3 bits = asuint(a) ^ asuint(b);
  return (bits.x | bits.y | bits.z) != 0u;
}

[numthreads(64, 1, 1)]
void find_moved_triangles(uint3 group : SV_GroupID, uint thread : SV_GroupIndex) {
  uint index = indexOfGroup(group) * 4u + thread / 16u;
  uint lane = thread % 16u;
  if (index >= g_fieldTriangleCount) return;
  PlacedTriangle before = loadTriangle(index, slotBefore());
  PlacedTriangle now = loadTriangle(index, slotNow());
  if (!differ(before.a, now.a) && !differ(before.b, now.b) && !differ(before.c, now.c) &&
      before.usable == now.usable)
    return;
  if (before.usable) addCrossings(before, -1, lane, 16u);
  if (now.usable) addCrossings(now, 1, lane, 16u);
  clearBricks(before, lane, 16u);
  clearBricks(now, lane, 16u);
  if (lane < 3u) {
    uint place = g_sdfIndices[3u * index + lane];
    if (place < g_placeCount) g_sdfMarks[placeMarks() + place] = g_buildStamp;
  }
  if (lane == 0u) InterlockedAdd(g_sdfWork[kWorkMovedTriangles], 1u);
}
