// Transforms the vertices into the space of the grid.
//
// Threads: one a point, in rows of kRowGroups groups.
// Reads:   g_sdfVertices, g_sdfPointVertices; incremental: g_sdfPoints of the last build
// Writes:  g_sdfPoints; incremental: g_sdfWork
//
// Coordinates are clamped at 65535 cells from node 0: beyond that a mesh keeps its topology but not
// its shape, and no integer of the crossings overflows. In an incremental build a vertex that moved
// by no more than g_motionTolerance since it was built keeps its position, and the passes of the
// rebuild get their groups only if some vertex moved.
//
// Invariant (tests/sdf): a vertex that is not finite has w = 0; without motion no pass of an
// incremental build has a group.
#include "sdf_triangle.hlsli"

static const float kRange = 65535.0;

groupshared uint s_moved;

float4 pointOf(uint pointIndex) {
  uint vertex = g_sdfPointVertices[pointIndex];
  if (vertex >= g_vertexCount) return float4(0.0, 0.0, 0.0, 0.0);
  uint first = g_vertexOffset + vertex * g_vertexStride;
  precise float3 p =
      float3(g_sdfVertices[first], g_sdfVertices[first + 1], g_sdfVertices[first + 2]);
  if (!isUsable(p)) return float4(0.0, 0.0, 0.0, 0.0);
  precise float3 cells = (p - g_sdfOrigin.xyz) / g_sdfOrigin.w;
  return float4(min(max(cells, -kRange), kRange), 1.0);
}

[numthreads(64, 1, 1)]
void compute_points(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint pointIndex = indexOfGroup(group) * 64u + lane;
  if (!isIncremental()) {
    if (pointIndex < g_pointCount)
      g_sdfPoints[slotNow() * g_pointCount + pointIndex] = pointOf(pointIndex);
    return;
  }
  if (lane == 0) s_moved = 0u;
  GroupMemoryBarrierWithGroupSync();
  if (pointIndex < g_pointCount) {
    float4 now = pointOf(pointIndex);
    float4 before = g_sdfPoints[slotBefore() * g_pointCount + pointIndex];
    precise float3 displacement = now.xyz - before.xyz;
    precise float limit = g_motionTolerance * g_motionTolerance;
    bool moved = now.w != before.w || dot3(displacement, displacement) > limit;
    float4 kept = before;
    if (moved) kept = now;
    g_sdfPoints[slotNow() * g_pointCount + pointIndex] = kept;
    if (moved) InterlockedAdd(s_moved, 1u);
  }
  GroupMemoryBarrierWithGroupSync();
  if (lane != 0) return;
  bool moves = s_moved > 0u;
  if (moves) {
    InterlockedAdd(g_sdfWork[kWorkMovedPoints], s_moved);
    InterlockedMax(g_sdfWork[kWorkMoved], g_triangleGroups);
    InterlockedMax(g_sdfWork[kWorkRows], g_rowGroups);
    InterlockedMax(g_sdfWork[kWorkInterior], g_coarseGroups);
    InterlockedMax(g_sdfWork[kWorkClear], g_clearGroups);
    InterlockedMax(g_sdfWork[kWorkColumns], g_columnGroups);
    InterlockedMax(g_sdfWork[kWorkLastMotion], g_buildStamp);
  }
  // Records with motion need one more pass, in which it ends.
  bool ends = g_sdfSurfaceStride > 4u && g_sdfWork[kWorkLastMotion] + 1u >= g_buildStamp;
  if (moves || ends) InterlockedMax(g_sdfWork[kWorkSurface], g_surfaceGroups);
}
