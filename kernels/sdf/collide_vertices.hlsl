// Moves vertices out of signed distance fields: for hair without strands between its vertices, and
// to measure. The solvers have the same contacts inside their loops.
//
// Threads: one a vertex, in rows of 2^20; LISTED: one a vertex of g_sdfNear, dispatchIndirect,
//          groups share the list.
// Reads:   g_sdfFields, g_sdfKeys, g_sdfSurface; LISTED: g_sdfNear
// Writes:  g_sdfPositions, g_sdfPositionsBefore
//
// A vertex that is nearer to a surface than its margin goes out along the normal. CLOSEST_FEATURE:
// the normal of the nearest feature, exact; else the gradient of the trilinear distance, which is 4
// degrees off and leaves one in seven vertices below the surface. WALK: steps from the triangles
// that the nodes know to nearer ones beside them.
// FRICTION: Coulomb's at position level. Of the way along the surface, relative to it, as much is
// taken as friction times the way outwards.
// A way of more than half a cell relative to the surface is swept: it stops at the surface, and
// goes on along it, swept again, up to kSdfRounds times. Then the vertex is where it stopped last.
// The velocity that is left has no part along the normal relative to the surface: the position
// before is moved, so that being pushed out is not a velocity.
//
// LISTED: only those vertices that find_near_vertices has listed. All else would keep their bits; in
// hair as it lies nearly every wave has one that is near, and waits for it.
//
// Invariant (tests/kernel): with LISTED the same bits as without; vertices without inverse mass,
// those that are not finite, and those that nothing touches keep their bits; what is inside is
// outside afterwards (99.9 %); a slope holds and lets slide as Coulomb says; what is thicker than
// 1.2 cells is not passed in a step of 16 cells.
#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE CLOSEST_FEATURE
#define SDF_WALK WALK
#define SDF_FRICTION FRICTION

#include "../layouts/apply_sdf.hlsli"
#include "sdf_near_list.hlsli"
#include "sdf_vertex.hlsli"

void collideVertex(uint index) {
  float4 now = g_sdfPositions[index];
  if (!(now.w > 0.0) || !isUsable(now)) return;
  float4 before = g_sdfPositionsBefore[index];
  SdfVertex vertex;
  vertex.now = now.xyz;
  vertex.before = isUsable(before.xyz) ? before.xyz : now.xyz;
  vertex.normal = float3(0.0, 0.0, 0.0);
  vertex.carried = float3(0.0, 0.0, 0.0);
  vertex.grip = 0.0;
  vertex.moved = false;
  for (uint f = 0; f < g_sdfFieldCount; ++f)
    collideWithField(vertex, g_sdfFields[f], g_sdfBegin, g_sdfEnd);
  if (!vertex.moved) return;
  g_sdfPositions[index] = float4(vertex.now, now.w);
  g_sdfPositionsBefore[index] = float4(vertex.before, before.w);
}

#if LISTED
[numthreads(64, 1, 1)]
void collide_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = min(g_sdfNear[kNearCount], g_sdfVertexCount);
  for (uint entry = group.x * 64u + lane; entry < count; entry += kNearGroups * 64u) {
    uint index = g_sdfNear[kNearList + entry];
    if (index < g_sdfVertexCount) collideVertex(index);
  }
}
#else
[numthreads(64, 1, 1)]
void collide_vertices(uint3 thread : SV_DispatchThreadID) {
  uint index = (thread.y << 20) | thread.x;
  if (index < g_sdfVertexCount) collideVertex(index);
}
#endif
