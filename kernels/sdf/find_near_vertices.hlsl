// Lists the vertices that collide_vertices may move.
//
// Threads: one a vertex, in rows of 2^20.
// Reads:   g_sdfPositions, g_sdfPositionsBefore, g_sdfFields, g_sdfKeys
// Writes:  g_sdfNear, whose first words the host has written
//
// The order of the list is any order; what becomes of a vertex does not depend on it.
//
// Invariant (tests/kernel): collide_vertices moves no vertex that is not listed; each is listed once.
#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE 0

#include "../layouts/apply_sdf.hlsli"
#include "sdf_near_list.hlsli"
#include "sdf_response.hlsli"

groupshared uint s_count;
groupshared uint s_first;

bool mayMove(uint index) {
  if (index >= g_sdfVertexCount) return false;
  float4 now = g_sdfPositions[index];
  if (!(now.w > 0.0) || !isUsable(now)) return false;
  float3 before = g_sdfPositionsBefore[index].xyz;
  if (!isUsable(before)) before = now.xyz;
  bool may = false;
  for (uint f = 0; f < g_sdfFieldCount && !may; ++f)
    may = sdfMayTouch(g_sdfFields[f], before, now.xyz, g_sdfEnd);
  return may;
}

[numthreads(64, 1, 1)]
void find_near_vertices(uint3 thread : SV_DispatchThreadID, uint lane : SV_GroupIndex) {
  uint index = (thread.y << 20) | thread.x;
  if (lane == 0u) s_count = 0u;
  GroupMemoryBarrierWithGroupSync();
  bool listed = mayMove(index);
  uint offset = 0u;
  if (listed) InterlockedAdd(s_count, 1u, offset);
  GroupMemoryBarrierWithGroupSync();
  if (lane == 0u && s_count > 0u) {
    uint first;
    InterlockedAdd(g_sdfNear[kNearCount], s_count, first);
    uint groups = (first + s_count + 63u) / 64u;
    InterlockedMax(g_sdfNear[kNearArguments], min(groups, kNearGroups));
    s_first = first;
  }
  GroupMemoryBarrierWithGroupSync();
  if (listed) g_sdfNear[kNearList + s_first + offset] = index;
}
