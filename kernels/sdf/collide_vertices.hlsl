// Moves vertices out of signed distance fields: for hair without strands between its vertices, and
// to measure. The solvers have the same contacts inside their loops.
//
// Threads: one a vertex, in rows of 2^20.
// Reads:   g_sdfFields, g_sdfKeys, g_sdfSurface
// Writes:  g_sdfPositions, g_sdfPositionsBefore
//
// A vertex that is nearer to a surface than its margin goes out along the normal. CLOSEST_FEATURE:
// the normal of the nearest feature, exact; else the gradient of the trilinear distance, which is 4
// degrees off and leaves one in seven vertices below the surface.
// Coulomb's friction, at position level: of the way along the surface, relative to it, as much is
// taken as friction times the way outwards.
// A way of more than half a cell relative to the surface is swept: it stops at the surface, and
// goes on along it, swept again, up to kSdfRounds times. Then the vertex is where it stopped last.
// The velocity that is left has no part along the normal relative to the surface: the position
// before is moved, so that being pushed out is not a velocity.
//
// A group first lists the vertices that a surface may touch, then moves those: in hair as it lies
// one vertex in 16 is near, and nearly every wave has one, for which all of it would wait. What
// becomes of a vertex does not depend on its place in the list.
//
// Invariant (tests/kernel): vertices without inverse mass, those that are not finite, and those that
// nothing touches keep their bits; what is inside is outside afterwards (99.9 %); what becomes of a
// vertex does not depend on those beside it; a slope holds and lets slide as Coulomb says; what is
// thicker than 1.2 cells is not passed in a step of 16 cells.
#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE CLOSEST_FEATURE

#include "../layouts/apply_sdf.hlsli"
#include "sdf_vertex.hlsli"

static const uint kThreads = 64;
static const uint kVerticesAGroup = 64;

groupshared uint s_count;
groupshared uint s_near[kVerticesAGroup];

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

void collideVertex(uint index) {
  float4 now = g_sdfPositions[index];
  float4 before = g_sdfPositionsBefore[index];
  SdfVertex vertex;
  vertex.now = now.xyz;
  vertex.before = isUsable(before.xyz) ? before.xyz : now.xyz;
  vertex.moved = false;
  for (uint f = 0; f < g_sdfFieldCount; ++f)
    collideWithField(vertex, g_sdfFields[f], g_sdfBegin, g_sdfEnd);
  if (!vertex.moved) return;
  g_sdfPositions[index] = float4(vertex.now, now.w);
  g_sdfPositionsBefore[index] = float4(vertex.before, before.w);
}

[numthreads(64, 1, 1)]
void collide_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint first = (group.y << 20) + group.x * kVerticesAGroup;
  if (lane == 0u) s_count = 0u;
  GroupMemoryBarrierWithGroupSync();
  for (uint i = lane; i < kVerticesAGroup; i += kThreads) {
    if (!mayMove(first + i)) continue;
    uint slot;
    InterlockedAdd(s_count, 1u, slot);
    s_near[slot] = first + i;
  }
  GroupMemoryBarrierWithGroupSync();
  for (uint entry = lane; entry < s_count; entry += kThreads) collideVertex(s_near[entry]);
}
