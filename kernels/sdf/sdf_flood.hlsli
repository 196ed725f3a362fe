// The list of inside nodes to which the flood brings triangles.
//
// While it lasts, the key of such a node is kSdfInside | kSdfFar | its entry.
#ifndef PELAGE_SDF_SDF_FLOOD_HLSLI
#define PELAGE_SDF_SDF_FLOOD_HLSLI

#include "sdf_triangle.hlsli"

static const uint kEntryKey = 0xc0000000u;

bool isEntryKey(uint key) { return (key & kEntryKey) == kEntryKey; }

groupshared uint s_listed;
groupshared uint s_firstEntry;

// Reserves entries for all threads of the group, which all call it; returns the first one of this
// thread. Which entry a node gets depends on the order of groups; nothing else does.
uint reserveEntries(uint count, uint lane) {
  if (lane == 0u) s_listed = 0u;
  GroupMemoryBarrierWithGroupSync();
  uint offset = 0u;
  if (count > 0u) InterlockedAdd(s_listed, count, offset);
  GroupMemoryBarrierWithGroupSync();
  if (lane == 0u && s_listed > 0u) {
    uint first;
    InterlockedAdd(g_sdfWork[kWorkFloodCount], s_listed, first);
    uint last = min(first + s_listed, g_floodCapacity);
    InterlockedMax(g_sdfWork[kWorkFlood], min((last + 63u) / 64u, kFloodGroups));
    s_firstEntry = first;
  }
  GroupMemoryBarrierWithGroupSync();
  return s_firstEntry + offset;
}

// \param node  index without g_fieldNodes.w
// \return its key: without an entry when the list is full
uint listNode(uint node, uint entry) {
  if (entry >= g_floodCapacity) return kSdfInside | kSdfUnset;
  g_sdfFlood[entry] = node;
  return kEntryKey | entry;
}

uint entryCount() { return min(g_sdfWork[kWorkFloodCount], g_floodCapacity); }
uint floodElement(uint slot, uint entry) { return (1u + (slot & 1u)) * g_floodCapacity + entry; }

int3 nodeOfIndex(uint index) {
  uint row = index / g_fieldNodes.x;
  uint layer = row / g_fieldNodes.y;
  return int3(uint3(index - row * g_fieldNodes.x, row - layer * g_fieldNodes.y, layer));
}

bool isInGrid(int3 node) {
  return min(node.x, min(node.y, node.z)) >= 0 && node.x < int(g_fieldNodes.x) &&
         node.y < int(g_fieldNodes.y) && node.z < int(g_fieldNodes.z);
}

float squaredDistanceTo(float3 p, uint index) {
  uint element = g_fieldSurface + index * g_fieldSurfaceStride;
  float3 a = asfloat(g_sdfSurface[element].xyz);
  float3 b = asfloat(g_sdfSurface[element + 1u].xyz);
  float3 c = asfloat(g_sdfSurface[element + 2u].xyz);
  return squaredDistance(p, shapeOf(a, b, c));
}

// The nearest triangle so far; of equally near ones the first.
struct Nearest {
  uint index;
  float squared;
};

Nearest nearer(Nearest now, float3 p, uint index) {
  if (index == now.index || index >= g_fieldTriangleCount) return now;
  float squared = squaredDistanceTo(p, index);
  if (squared > now.squared || (squared == now.squared && index > now.index)) return now;
  Nearest result;
  result.index = index;
  result.squared = squared;
  return result;
}

Nearest noneNear() {
  Nearest result;
  result.index = kSdfNone;
  result.squared = 1e30;
  return result;
}

#endif
