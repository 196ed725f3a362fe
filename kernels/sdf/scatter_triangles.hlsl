// Gives every node within the band the key of the nearest triangle, and counts crossings.
//
// Threads: 16 a triangle, in rows of kRowGroups groups of 64.
// Reads:   g_sdfPoints, g_sdfIndices; of bricks g_sdfMarks
// Writes:  g_sdfKeys, g_sdfCounts, which clear_sdf or find_moved_triangles has cleared; g_sdfWork
//
// Threads per triangle, on an H200 at 100 cells across the body: 1 takes 108 us, 8 34, 16 30, 32
// 30, 64 34. Reading the key before the atomic made each of them slower. A triangle whose range has
// more than 512 nodes, or twice those of a triangle of two cells, is left to scatter_big_triangles:
// one thread per triangle balances well enough for ranges that all triangles have, and a group of
// 64 for some bricks of each costs 30 times as much on a CPU (1,700 triangles, band 4). In a build
// of bricks, it writes only nodes of the bricks that this build cleared; find_moved_triangles has
// processed the crossings.
//
// Invariant (tests/sdf): keys are within half a code of the distance to the nearest triangle,
// and the same bits in any order of threads; a build of bricks gives the same bits as from an empty
// grid.
#include "sdf_bricks.hlsli"
#include "sdf_crossings.hlsli"

static const float kBigNodes = 512.0;

float mostNodes() {
  precise float extent = 2.0 * g_sdfBand + 2.0;
  precise float nodes = 2.0 * extent * extent * extent;
  return max(nodes, kBigNodes);
}

groupshared uint s_touched[kScatteredTriangles];

void leaveToBigOnes(uint index, int3 extent) {
  uint slot;
  InterlockedAdd(g_sdfWork[kWorkBigCount], 1u, slot);
  if (slot >= g_sdfTriangleCount) return;
  g_sdfWork[kWorkBigList + slot] = index;
  uint3 bricks = uint3(extent + 6) / 4u;
  uint shares = min(bricks.x * bricks.y * bricks.z / kBricksAShare + 1u, kMostShares);
  InterlockedMax(g_sdfWork[kWorkBig], min(slot + 1u, kBigGroups));
  InterlockedMax(g_sdfWork[kWorkBig + 1], shares);
}

[numthreads(64, 1, 1)]
void scatter_triangles(uint3 group : SV_GroupID, uint thread : SV_GroupIndex) {
  uint index = indexOfGroup(group) * kScatteredTriangles + thread / kScatterLanes;
  uint lane = thread % kScatterLanes;
  PointTriangle t;
  t.a = float3(0.0, 0.0, 0.0);
  t.b = t.a;
  t.c = t.a;
  t.usable = false;
  if (index < g_sdfTriangleCount) t = loadTriangle(index, slotNow());
  NodeRange range = rangeOf(t);
  bool overlaps = t.usable && !isEmpty(range);
  int3 extent = range.high - range.low + 1;

  bool ofBricks = isOfBricks();
  if (ofBricks) {
    if (lane == 0) s_touched[thread / kScatterLanes] = 0u;
    GroupMemoryBarrierWithGroupSync();
    if (overlaps && touchesMarkedBricks(range, lane, kScatterLanes))
      InterlockedOr(s_touched[thread / kScatterLanes], 1u);
    GroupMemoryBarrierWithGroupSync();
    overlaps = overlaps && s_touched[thread / kScatterLanes] != 0u;
  }

  if (!t.usable) return;
  // As floats: a giant's extents would overflow.
  precise float volume = float(extent.x) * float(extent.y) * float(extent.z);
  bool big = overlaps && volume > mostNodes();
  // A triangle that reaches no node still has crossings before the first one.
  if (!ofBricks && !big) addCrossings(t, 1, lane, kScatterLanes);
  if (!overlaps) return;
  if (big) {
    if (lane == 0) leaveToBigOnes(index, extent);
    return;
  }
  TriangleShape shape = shapeOf(t.a, t.b, t.c);
  if (!shape.hasArea) return;
  int count = extent.x * extent.y * extent.z;
  float across = shareOf(extent.x);
  float down = shareOf(extent.y);
  for (int i = int(lane); i < count; i += kScatterLanes) {
    int row = quotient(i, across);
    int layer = quotient(row, down);
    int3 node = range.low + int3(i - row * extent.x, row - layer * extent.y, layer);
    if (ofBricks && !isMarkedNode(node)) continue;
    scatterNode(node, index, shape);
  }
}
