// Gives the coarse nodes that are deep inside the triangle that is nearest to them: of every 2 or 4
// nodes along each axis one, sdfCoarseStride() says which. Queries between them start from the eight
// around.
//
// Threads: a group of 64 a coarse node, in rows of kGroupsARow groups.
// Reads:   g_sdfKeys, g_sdfSurface
// Writes:  g_sdfKeys of coarse nodes that are inside and have no triangle, g_sdfWork
//
// Each thread goes from the node in a direction of its own until a key knows a triangle; steps of
// the band cannot pass the nodes that do. No thread goes further than the nearest triangle that was
// found. Then the group looks at the 4^3 nodes around the closest point, and again from where that
// leads, while it is nearer.
// Only keys within the band are read, and only others are written: the result depends on no order.
// Keys of nodes that parts of the mesh overlap have no triangle (finalize_sdf), so that every
// triangle here leads out.
//
// Invariant (tests/kernel): the triangle is the nearest one, or at most half a cell further away;
// no coarse node inside is left without one while there is a surface on one of its axes.
#include "sdf_record.hlsli"

// Looks around the closest point.
static const uint kLooks = 6;

groupshared uint s_squared;  // bits of the least distance^2
groupshared uint s_index;    // first triangle that is as near
groupshared float3 s_foot;   // its closest point

// A key of the band, else kSdfUnset.
uint nearKeyAt(int3 node) {
  if (!isInGrid(node)) return kSdfUnset;
  uint key = g_sdfKeys[g_fieldNodes.w + nodeIndex(node)];
  return (key & kSdfFar) != 0u ? kSdfUnset | (key & kSdfInside) : key;
}

bool hasTriangle(uint key) {
  return sdfTriangle(key, g_fieldTriangleBits) < g_fieldTriangleCount;
}

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
  uint index = sdfTriangle(key, g_fieldTriangleBits);
  if (index >= g_fieldTriangleCount || index == best.index) return;
  SdfClosest found = closestOf(p, index);
  if (found.squared < best.squared ||
      (found.squared == best.squared && found.index < best.index))
    best = found;
}

// The nearest of all threads' to s_index and s_foot.
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
  uint stride = sdfCoarseStride(g_fieldBand);
  uint3 coarse = (g_fieldNodes.xyz + stride - 1u) / stride;
  uint index = indexOfGroup(group);
  uint row = index / coarse.x;
  uint layer = row / coarse.y;
  if (layer >= coarse.z) return;
  int3 node = int3(stride * uint3(index - row * coarse.x, row - layer * coarse.y, layer));
  uint element = g_fieldNodes.w + nodeIndex(node);
  uint key = g_sdfKeys[element];
  if (!sdfIsInside(key) || hasTriangle(key)) return;

  float3 p = float3(node);
  float3 direction = directionOf(lane);
  SdfClosest best = noTriangle();
  if (lane == 0u) s_squared = asuint(best.squared);
  bool goes = true;
  float end = float(g_fieldNodes.x + g_fieldNodes.y + g_fieldNodes.z);
  for (float way = g_fieldBand; way < end; way += g_fieldBand) {
    if (goes) {
      precise float3 at = p + direction * way;
      uint met = nearKeyAt(int3(floor(at + 0.5)));
      goes = sdfIsInside(met);
      if (hasTriangle(met)) {
        goes = false;
        offer(best, p, met);
        InterlockedMin(s_squared, asuint(best.squared));
      }
    }
    GroupMemoryBarrierWithGroupSync();
    // A triangle further on is at most the band and half a cell's diagonal nearer than its node.
    precise float least = max(way - 1.0, 0.0);
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
  // What is nearer was deeper inside of another part: its key is right as it is.
  if (sdfIsSet(key) && distance < g_fieldBand) return;
  InterlockedAdd(g_sdfWork[kWorkInteriorCount], 1u);
  g_sdfKeys[element] = kSdfInside | sdfFarKey(distance, s_index, g_fieldBand, g_fieldFarRange,
                                              g_fieldTriangleBits);
}
