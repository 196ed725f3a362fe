// Ends the flood: writes the keys of the listed nodes.
//
// Threads: one an entry, 64 a group; dispatchIndirect, groups share the entries.
// Reads:   g_sdfFlood, g_sdfKeys, g_sdfSurface, g_sdfWork
// Writes:  g_sdfKeys
//
// The triangle that the flood found is close to the nearest one: a walk over neighbours while they
// are nearer comes closer; with THREE_AXES only to such as lead out. A node that no triangle came to
// looks along the axes for a surface.
//
// Invariant (tests/kernel): no inside node is left unset while there is a surface on one of its
// axes.
#include "sdf_flood.hlsli"
#if THREE_AXES
#include "sdf_way_out.hlsli"
#define NEARER nearerOut
#else
#define NEARER nearer
#endif

static const uint kWalk = 4;

Nearest walk(Nearest best, float3 p) {
  for (uint step = 0; step < kWalk; ++step) {
    uint from = best.index;
    if (from >= g_fieldTriangleCount) return best;
    uint3 around = g_sdfSurface[g_fieldSurface + from * g_fieldSurfaceStride + 3u].xyz;
    best = NEARER(best, p, around.x);
    best = NEARER(best, p, around.y);
    best = NEARER(best, p, around.z);
    if (best.index == from) return best;
  }
  return best;
}

// Only outside nodes are looked at: their keys do not change here.
Nearest searchAxes(int3 node, float3 p) {
  Nearest best = noneNear();
  for (uint direction = 0; direction < 6; ++direction) {
    int side = (direction & 1u) != 0u ? 1 : -1;
    uint axis = direction / 2u;
    int3 way = int3(axis == 0u ? side : 0, axis == 1u ? side : 0, axis == 2u ? side : 0);
    int3 at = node + way;
    bool found = false;
    while (isInGrid(at) && !found) {
      uint key = g_sdfKeys[g_fieldNodes.w + nodeIndex(at)];
      found = !sdfIsInside(key) && sdfIsSet(key);
      if (found) best = nearer(best, p, sdfTriangle(key, g_fieldTriangleBits));
      at += way;
    }
  }
  return best;
}

[numthreads(64, 1, 1)]
void write_interior(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = entryCount();
  for (uint entry = group.x * 64u + lane; entry < count; entry += kFloodGroups * 64u) {
    uint index = g_sdfFlood[entry];
    int3 node = nodeOfIndex(index);
    float3 p = float3(node);
    Nearest best = nearer(noneNear(), p, g_sdfFlood[floodElement(g_floodSlot, entry)]);
    if (best.index >= g_fieldTriangleCount) best = searchAxes(node, p);
    best = walk(best, p);
    uint key = kSdfInside | kSdfUnset;
    if (best.index < g_fieldTriangleCount) {
      float distance = squareRoot(best.squared);
      uint magnitude = sdfFarKey(distance, best.index, g_fieldBand, g_fieldFarRange,
                                 g_fieldTriangleBits);
      if (distance <= g_fieldBand)
        magnitude = sdfNearKey(distance, best.index, g_fieldBand, g_fieldTriangleBits);
      key = kSdfInside | magnitude;
    }
    g_sdfKeys[g_fieldNodes.w + index] = key;
  }
}
