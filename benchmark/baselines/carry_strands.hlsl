// Classic baseline: velocity shock propagation (sweeps_layout.hlsli). Both positions of a vertex
// are blended with where the root's motion would have taken them. The rotation is the shortest
// between the old and the new first edge, so a twist about it is lost.
// Threads: one a vertex. Reads g_bind, g_places, g_placesBefore; writes the last two.
#include "rotations.hlsli"
#include "sweeps_layout.hlsli"

[numthreads(64, 1, 1)]
void carry_strands(uint3 thread : SV_DispatchThreadID) {
  uint index = thread.x;
  if (index >= g_strandCount * g_vertexCount || g_restart != 0) return;
  uint vertex = index % g_vertexCount;
  float inverseMass = g_bind[index].w;
  if (!isFree(vertex, inverseMass)) return;
  float3 bindRoot = g_bind[index - vertex].xyz;
  float3 bindEdge = g_bind[index - vertex + 1].xyz - bindRoot;
  float3 root = rotate(g_rotation, bindRoot) + g_shift.xyz;
  float3 rootBefore = rotate(g_rotationBefore, bindRoot) + g_shiftBefore.xyz;
  float3 rootEarlier = rotate(g_rotationEarlier, bindRoot) + g_shiftEarlier.xyz;
  float4 turn = rotationBetween(normalize(rotate(g_rotationBefore, bindEdge)),
                                normalize(rotate(g_rotation, bindEdge)));
  float acceleration = length(root - 2.0 * rootBefore + rootEarlier);
  float share = acceleration > g_carryThreshold ? 1.0 : g_carryShare;
  float3 place = g_places[index].xyz;
  float3 before = g_placesBefore[index].xyz;
  float3 carried = root + rotate(turn, place - rootBefore);
  float3 carriedBefore = root + rotate(turn, before - rootBefore);
  g_places[index] = float4(lerp(place, carried, share), inverseMass);
  g_placesBefore[index] = float4(lerp(before, carriedBefore, share), inverseMass);
}
