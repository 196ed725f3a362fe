// Moves the crossings of triangles that moved from their old to their new position, and clears the
// bricks that their bands touch at both.
//
// Threads: 16 a triangle, in rows of kRowGroups groups of 64; dispatchIndirect.
// Reads:   g_sdfPoints of this build and of the last one, g_sdfIndices
// Writes:  g_sdfCounts, g_sdfMarks, g_sdfKeys, g_sdfWork
//
// The group that marks a brick first clears it: no other pass touches keys before
// scatter_triangles. The marks of vertices are set where a normal changes.
//
// Invariant (tests/sdf): crossings are those of a build from an empty grid.
#include "sdf_bricks.hlsli"
#include "sdf_crossings.hlsli"

// Bricks that the group clears together, one node per thread: one thread would need 64 iterations.
static const uint kMostListed = 256;
groupshared uint s_listed;
groupshared uint s_bricks[kMostListed];

void clearNode(uint3 brick, uint i) {
  uint3 node = brick * 4u + uint3(i & 3u, (i >> 2) & 3u, i >> 4);
  if (node.y < g_sdfNodes.y && node.z < g_sdfNodes.z)
    g_sdfKeys[g_sdfNodes.w + nodeIndex(int3(node))] = kSdfUnset;
}

// Lists the brick, or clears it if the list is full.
void listBrick(uint3 brick) {
  uint slot;
  InterlockedAdd(s_listed, 1u, slot);
  if (slot < kMostListed) {
    s_bricks[slot] = brickIndex(brick);
    return;
  }
  for (uint i = 0; i < 64; ++i) clearNode(brick, i);
}

void clearListed(uint thread) {
  uint3 bricks = bricksOfGrid();
  uint count = min(s_listed, kMostListed);
  for (uint entry = 0; entry < count; ++entry) {
    uint index = s_bricks[entry];
    uint row = index / bricks.x;
    uint layer = row / bricks.y;
    clearNode(uint3(index - row * bricks.x, row - layer * bricks.y, layer), thread);
  }
}

// Marks and lists the bricks that the band of a triangle touches.
void findBricks(PointTriangle t, uint lane, uint lanes) {
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
    listBrick(brick);
  }
}

bool differ(float3 a, float3 b) {
  uint3 bits = asuint(a) ^ asuint(b);
  return (bits.x | bits.y | bits.z) != 0u;
}

// Moves the crossings of a triangle if it has moved, and marks the bricks and points that it
// changes.
void moveTriangle(uint index, uint lane) {
  if (index >= g_sdfTriangleCount) return;
  PointTriangle before = loadTriangle(index, slotBefore());
  PointTriangle now = loadTriangle(index, slotNow());
  if (!differ(before.a, now.a) && !differ(before.b, now.b) && !differ(before.c, now.c) &&
      before.usable == now.usable)
    return;
  if (before.usable) addCrossings(before, -1, lane, 16u);
  if (now.usable) addCrossings(now, 1, lane, 16u);
  findBricks(before, lane, 16u);
  findBricks(now, lane, 16u);
  if (lane < 3u) {
    uint pointIndex = g_sdfIndices[3u * index + lane];
    if (pointIndex < g_pointCount) g_sdfMarks[pointMarks() + pointIndex] = g_buildStamp;
  }
  if (lane == 0u) InterlockedAdd(g_sdfWork[kWorkMovedTriangles], 1u);
}

[numthreads(64, 1, 1)]
void find_moved_triangles(uint3 group : SV_GroupID, uint thread : SV_GroupIndex) {
  if (thread == 0u) s_listed = 0u;
  GroupMemoryBarrierWithGroupSync();
  moveTriangle(indexOfGroup(group) * kScatteredTriangles + thread / kScatterLanes,
               thread % kScatterLanes);
  GroupMemoryBarrierWithGroupSync();
  clearListed(thread);
  if (thread == 0u && s_listed > 0u) InterlockedAdd(g_sdfWork[kWorkBricks], s_listed);
}
