// Moves vertices out of SDFs: for hair that needs no contacts between its vertices, and for
// measurements. The solvers use the records of find_contacts instead.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_sdfs, g_sdfKeys, g_sdfSurface
// Writes:  g_sdfPositions, g_sdfPositionsBefore
//
// A vertex nearer to a surface than its margin moves out along the normal. CLOSEST_FEATURE: along
// the exact normal of the nearest feature; otherwise along the gradient of the trilinear distance,
// which is 4 degrees off and leaves one in seven vertices below the surface. Coulomb friction, at
// position level: it removes at most friction times the outward displacement from the displacement
// along the surface, relative to the surface. A displacement of more than half a cell relative to
// the surface is swept: it stops at the surface and continues along it, swept again, up to
// kSdfRounds times. Then the vertex is where it stopped last. The remaining velocity has no part
// along the normal relative to the surface: the previous position is moved, too, so that being
// pushed out is not a velocity.
//
// A group first lists the vertices that a surface may touch, then moves those: for hair at rest one
// vertex in 16 is near, and nearly every wave has one, for which all its threads would wait. The
// result of a vertex does not depend on its index in the list.
//
// Invariant (tests/sdf): vertices without inverse mass, those that are not finite, and those
// without contact keep their bits; vertices that were inside are outside afterwards (99.9 %); the
// result of a vertex does not depend on the others; friction on a slope holds and slips as Coulomb
// says; no vertex passes through what is thicker than 1.2 cells in a step of 16 cells.
#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE CLOSEST_FEATURE

#include "../base/dispatch.hlsli"
#include "layouts/apply_sdf.hlsli"
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
  for (uint f = 0; f < g_sdfCount && !may; ++f)
    may = sdfMayCollide(g_sdfs[f], before, now.xyz, g_sdfEnd);
  return may;
}

void collideVertex(uint index) {
  float4 now = g_sdfPositions[index];
  float4 before = g_sdfPositionsBefore[index];
  SdfVertex vertex;
  vertex.now = now.xyz;
  vertex.before = isUsable(before.xyz) ? before.xyz : now.xyz;
  vertex.moved = false;
  for (uint f = 0; f < g_sdfCount; ++f)
    collideWithSdf(vertex, g_sdfs[f], g_sdfBegin, g_sdfEnd);
  if (!vertex.moved) return;
  g_sdfPositions[index] = float4(vertex.now, now.w);
  g_sdfPositionsBefore[index] = float4(vertex.before, before.w);
}

[numthreads(64, 1, 1)]
void collide_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint first = (group.y << kRowBits) + group.x * kVerticesAGroup;
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
