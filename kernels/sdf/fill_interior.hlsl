// Gives each coarse node that is deep inside its nearest triangle. One of every 2 or 4 nodes along
// each axis is a coarse node; sdfCoarseStride() returns the stride. Queries between them start from
// the eight around.
//
// Threads: a group of 64 a coarse node, in rows of kRowGroups groups.
// Reads:   g_sdfKeys, g_sdfSurface
// Writes:  g_sdfKeys of coarse nodes that are inside and have no triangle, g_sdfWork
//
// Each thread marches from the node in its own direction until a key names a triangle; steps of the
// band's width cannot pass the nodes that have one. No thread goes further than the nearest
// triangle found so far. Then the group searches the 4^3 nodes around the closest point, and again
// around the new closest point, while it gets nearer. Only keys within the band are read, and only
// others are written: the result depends on no order. Keys of nodes where parts of the mesh overlap
// have no triangle (finalize_sdf), so every triangle here leads out.
//
// Invariant (tests/sdf): the triangle is the nearest one, or at most half a cell further away;
// every coarse node inside has one if there is a surface on one of its axes.
#include "sdf_record.hlsli"

// Searches around the closest point.
static const uint kLooks = 6;

groupshared uint s_squared;  // bits of the least distance^2
groupshared uint s_index;    // first triangle that is as near
groupshared float3 s_foot;   // its closest point

// A key of the band, else kSdfUnset.
uint nearKeyAt(int3 node) {
  if (!isInGrid(node)) return kSdfUnset;
  uint key = g_sdfKeys[g_sdfNodes.w + nodeIndex(node)];
  return (key & kSdfFar) != 0u ? kSdfUnset | (key & kSdfInside) : key;
}

bool hasTriangle(uint key) { return sdfTriangle(key, g_sdfTriangleBits) < g_sdfTriangleCount; }

// The 64 points of { -3, -1, 1, 3 }^3, of which the inner eight would lead where the outer corners
// do: six of them are the axes.
float3 directionOf(uint lane) {
  int3 i = int3(uint3(lane & 3u, (lane >> 2) & 3u, lane >> 4));
  int3 d = 2 * i - 3;
  if (max(abs(d.x), max(abs(d.y), abs(d.z))) == 1) {
    uint inner = uint(i.x - 1) | (uint(i.y - 1) << 1) | (uint(i.z - 1) << 2);
    int side = (inner & 1u) != 0u ? 1 : -1;
    uint axis = inner >> 1;
    d = int3(axis == 0u ? side : 0, axis == 1u ? side : 0, axis == 2u ? side : 0);
  }
  return directionOr(float3(d), float3(1.0, 0.0, 0.0));
}

void offer(inout SdfClosest best, float3 p, uint key) {
  uint index = sdfTriangle(key, g_sdfTriangleBits);
  if (index >= g_sdfTriangleCount || index == best.index) return;
  SdfClosest found = closestOf(p, index);
  if (found.squared < best.squared || (found.squared == best.squared && found.index < best.index))
    best = found;
}

// Reduces all threads' nearest triangles to s_index and s_foot.
void share(SdfClosest best, float3 p, uint lane) {
  if (lane == 0u) s_index = kSdfNone;
  GroupMemoryBarrierWithGroupSync();
  if (best.index != kSdfNone) InterlockedMin(s_squared, asuint(best.squared));
  GroupMemoryBarrierWithGroupSync();
  bool nearest = best.index != kSdfNone && asuint(best.squared) == s_squared;
  if (nearest) InterlockedMin(s_index, best.index);
  GroupMemoryBarrierWithGroupSync();
  precise float3 foot = p - best.offset;
  if (nearest && best.index == s_index) s_foot = foot;
  GroupMemoryBarrierWithGroupSync();
}

[numthreads(64, 1, 1)]
void fill_interior(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint stride = sdfCoarseStride(g_sdfBand);
  uint3 coarse = (g_sdfNodes.xyz + stride - 1u) / stride;
  uint index = indexOfGroup(group);
  uint row = index / coarse.x;
  uint layer = row / coarse.y;
  if (layer >= coarse.z) return;
  int3 node = int3(stride * uint3(index - row * coarse.x, row - layer * coarse.y, layer));
  uint element = g_sdfNodes.w + nodeIndex(node);
  uint key = g_sdfKeys[element];
  if (!sdfIsInside(key) || hasTriangle(key)) return;

  float3 p = float3(node);
  float3 direction = directionOf(lane);
  SdfClosest best = noTriangle();
  if (lane == 0u) s_squared = asuint(best.squared);
  bool goes = true;
  float end = float(g_sdfNodes.x + g_sdfNodes.y + g_sdfNodes.z);
  for (float travelled = g_sdfBand; travelled < end; travelled += g_sdfBand) {
    if (goes) {
      precise float3 at = p + direction * travelled;
      uint met = nearKeyAt(int3(floor(at + 0.5)));
      goes = sdfIsInside(met);
      if (hasTriangle(met)) {
        goes = false;
        offer(best, p, met);
        InterlockedMin(s_squared, asuint(best.squared));
      }
    }
    GroupMemoryBarrierWithGroupSync();
    // A triangle beyond this node is nearer than the node by at most the band and half a cell's
    // diagonal.
    precise float least = max(travelled - 1.0, 0.0);
    bool done = least * least > asfloat(s_squared);
    GroupMemoryBarrierWithGroupSync();
    if (done) break;
  }
  share(best, p, lane);
  for (uint look = 0; look < kLooks; ++look) {
    uint known = s_index;
    if (known == kSdfNone) break;
    int3 low = int3(floor(s_foot)) - 1;
    GroupMemoryBarrierWithGroupSync();
    offer(best, p, nearKeyAt(low + int3(uint3(lane & 3u, (lane >> 2) & 3u, lane >> 4))));
    share(best, p, lane);
    if (s_index == known) break;
  }
  if (lane != 0u || s_index == kSdfNone) return;
  precise float distance = squareRoot(asfloat(s_squared));
  // A nearer one was deeper inside another part: its key is correct.
  if (sdfIsSet(key) && distance < g_sdfBand) return;
  InterlockedAdd(g_sdfWork[kWorkInteriorCount], 1u);
  g_sdfKeys[element] =
      kSdfInside | sdfFarKey(distance, s_index, g_sdfBand, g_sdfFarRange, g_sdfTriangleBits);
}
