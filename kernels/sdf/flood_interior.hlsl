// Brings each listed node the nearest of the triangles that the nodes around it, g_floodStep away,
// know: jump flooding (Rong and Tan, "Jump flooding in GPU with applications to Voronoi diagram and
// distance transform", I3D 2006) on triangles instead of points.
//
// With THREE_AXES an entry starts from its own nearest triangle, and only what leads out counts.
//
// Threads: one an entry, 64 a group; dispatchIndirect, groups share the entries. (Eight an entry,
//          without repeated triangles, took as long for 32 k entries and 2.5 times as long for 250 k.)
// Reads:   g_sdfFlood, g_sdfKeys, g_sdfSurface, g_sdfWork
// Writes:  g_sdfFlood
//
// The triangles of the last step are read and those of this one are written elsewhere, so that the
// result does not depend on the order of threads. Nodes near the surface have theirs in their keys.
//
// Invariant (tests/kernel): after all steps the distance is within 0.1 cell.
#include "sdf_flood.hlsli"
#if THREE_AXES
#include "sdf_way_out.hlsli"
#define NEARER nearerOut
#else
#define NEARER nearer
#endif

uint triangleAt(int3 node, bool started) {
  if (!isInGrid(node)) return kSdfNone;
  uint key = g_sdfKeys[g_fieldNodes.w + nodeIndex(node)];
  if (isEntryKey(key)) {
    uint entry = key & (kSdfFar - 1u);
    // One of a full list is none.
    if (!started || entry >= g_floodCapacity) return kSdfNone;
    return g_sdfFlood[floodElement(g_floodSlot, entry)];
  }
  return sdfIsSet(key) ? sdfTriangle(key, g_fieldTriangleBits) : kSdfNone;
}

[numthreads(64, 1, 1)]
void flood_interior(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = entryCount();
  bool started = (g_floodFlags & 1u) == 0u;
  for (uint entry = group.x * 64u + lane; entry < count; entry += kFloodGroups * 64u) {
    int3 node = nodeOfIndex(g_sdfFlood[entry]);
    float3 p = float3(node);
    Nearest best = noneNear();
    if (started || THREE_AXES)
      best = NEARER(best, p, g_sdfFlood[floodElement(g_floodSlot, entry)]);
    uint last = kSdfNone;
    for (uint i = 0; i < 27; ++i) {
      int3 way = int3(uint3(i % 3u, (i / 3u) % 3u, i / 9u)) - 1;
      if (i == 13) continue;
      uint index = triangleAt(node + way * int(g_floodStep), started);
      // Neighbours often know the same one.
      if (index != last) best = NEARER(best, p, index);
      last = index;
    }
    g_sdfFlood[floodElement(g_floodSlot + 1u, entry)] = best.index;
  }
}
