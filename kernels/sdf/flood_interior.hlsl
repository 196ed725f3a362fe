// Brings each listed node the nearest of the triangles that the nodes around it, g_floodStep away,
// know: jump flooding (Rong and Tan, "Jump flooding in GPU with applications to Voronoi diagram and
// distance transform", I3D 2006) on triangles instead of points.
//
// With THREE_AXES an entry starts from its own nearest triangle, and only what leads out counts.
//
// Threads: eight an entry, 64 a group; dispatchIndirect, groups share the entries. One an entry left
//          most of a GPU idle.
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

// Threads that share an entry, and entries of a group.
static const uint kSharing = 8;
static const uint kEntries = 8;
static const uint kAround = 27;

groupshared uint s_around[216];  // [entry][node around it], kEntries * kAround
groupshared uint s_index[64];
groupshared float s_squared[64];

// Whether a node before this one of the same entry knows the same triangle.
bool isRepeated(uint first, uint i, uint index) {
  for (uint k = 0; k < i; ++k) {
    if (s_around[first + k] == index) return true;
  }
  return false;
}

[numthreads(64, 1, 1)]
void flood_interior(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = entryCount();
  bool started = (g_floodFlags & 1u) == 0u;
  uint own = lane / kSharing;
  uint part = lane % kSharing;
  uint first = own * kAround;
  for (uint base = group.x * kEntries; base < count; base += kFloodGroups * kEntries) {
    uint entry = base + own;
    bool listed = entry < count;
    int3 node = nodeOfIndex(g_sdfFlood[min(entry, count - 1u)]);
    for (uint i = part; i < kAround; i += kSharing) {
      int3 way = int3(uint3(i % 3u, (i / 3u) % 3u, i / 9u)) - 1;
      uint index = kSdfNone;
      // In the middle is the node itself.
      if (listed && i != kAround / 2u)
        index = triangleAt(node + way * int(g_floodStep), started);
      else if (listed && (started || THREE_AXES))
        index = g_sdfFlood[floodElement(g_floodSlot, entry)];
      s_around[first + i] = index;
    }
    GroupMemoryBarrierWithGroupSync();
    Nearest best = noneNear();
    float3 p = float3(node);
    for (uint k = part; k < kAround; k += kSharing) {
      uint index = s_around[first + k];
      if (index != kSdfNone && !isRepeated(first, k, index)) best = NEARER(best, p, index);
    }
    s_index[lane] = best.index;
    s_squared[lane] = best.squared;
    GroupMemoryBarrierWithGroupSync();
    if (part == 0u && listed) {
      for (uint other = 1; other < kSharing; ++other) {
        uint index = s_index[lane + other];
        float squared = s_squared[lane + other];
        if (squared < best.squared || (squared == best.squared && index < best.index)) {
          best.index = index;
          best.squared = squared;
        }
      }
      g_sdfFlood[floodElement(g_floodSlot + 1u, entry)] = best.index;
    }
    GroupMemoryBarrierWithGroupSync();
  }
}
