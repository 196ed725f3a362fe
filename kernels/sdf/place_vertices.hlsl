// Brings the vertices into the grid.
//
// Threads: one a place, in rows of kGroupsARow groups.
// Reads:   g_sdfVertices, g_sdfPlaceVertices; incremental: g_sdfPlaces of the last build
// Writes:  g_sdfPlaces; incremental: g_sdfWork
//
// Coordinates end 65535 cells from node 0: further out a mesh keeps its topology but not its shape,
// and no integer of the crossings overflows. In an incremental build a vertex that moved by no more than
// g_motionTolerance since it was built stays where it was, and the passes of the rebuild get their
// groups only when some vertex moved.
//
// Invariant (tests/kernel): a vertex that is not finite has w = 0; without motion no pass of an
// incremental build has a group.
#include "sdf_triangle.hlsli"

static const float kReach = 65535.0;

groupshared uint s_moved;

float4 placeOf(uint place) {
  uint vertex = g_sdfPlaceVertices[place];
  if (vertex >= g_vertexCount) return float4(0.0, 0.0, 0.0, 0.0);
  uint first = g_vertexOffset + vertex * g_vertexStride;
  precise float3 p =
      float3(g_sdfVertices[first], g_sdfVertices[first + 1], g_sdfVertices[first + 2]);
  if (!isUsable(p)) return float4(0.0, 0.0, 0.0, 0.0);
  precise float3 cells = (p - g_fieldOrigin.xyz) / g_fieldOrigin.w;
  return float4(min(max(cells, -kReach), kReach), 1.0);
}

[numthreads(64, 1, 1)]
void place_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint place = indexOfGroup(group) * 64u + lane;
  if (!isIncremental()) {
    if (place < g_placeCount) g_sdfPlaces[slotNow() * g_placeCount + place] = placeOf(place);
    return;
  }
  if (lane == 0) s_moved = 0u;
  GroupMemoryBarrierWithGroupSync();
  if (place < g_placeCount) {
    float4 now = placeOf(place);
    float4 before = g_sdfPlaces[slotBefore() * g_placeCount + place];
    precise float3 way = now.xyz - before.xyz;
    precise float limit = g_motionTolerance * g_motionTolerance;
    bool moved = now.w != before.w || dot3(way, way) > limit;
    float4 kept = before;
    if (moved) kept = now;
    g_sdfPlaces[slotNow() * g_placeCount + place] = kept;
    if (moved) InterlockedAdd(s_moved, 1u);
  }
  GroupMemoryBarrierWithGroupSync();
  if (lane != 0) return;
  bool moves = s_moved > 0u;
  if (moves) {
    InterlockedAdd(g_sdfWork[kWorkMovedPlaces], s_moved);
    InterlockedMax(g_sdfWork[kWorkMoved], g_triangleGroups);
    InterlockedMax(g_sdfWork[kWorkRows], g_rowGroups);
    InterlockedMax(g_sdfWork[kWorkInterior], g_coarseGroups);
    InterlockedMax(g_sdfWork[kWorkClear], g_clearGroups);
    InterlockedMax(g_sdfWork[kWorkColumns], g_columnGroups);
    InterlockedMax(g_sdfWork[kWorkLastMotion], g_buildStamp);
  }
  // Records with motion need a pass more, in which it ends.
  bool ends = g_fieldSurfaceStride > 4u && g_sdfWork[kWorkLastMotion] + 1u >= g_buildStamp;
  if (moves || ends) InterlockedMax(g_sdfWork[kWorkSurface], g_surfaceGroups);
}
