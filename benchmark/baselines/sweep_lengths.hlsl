// Classic baseline, last pass: edge lengths by Gauss-Seidel sweeps, all even edges, then all odd
// ones; and the tangents (sweeps_layout.hlsli).
// Threads: 64 a group, one a vertex of 64 / g_vertexCount strands.
// Reads g_bind, g_edges, g_places; writes g_places, g_directions.
#include "sweeps_layout.hlsli"

groupshared float4 s_places[64];

void fitEdge(uint at, uint next, float rest) {
  float4 a = s_places[at];
  float4 b = s_places[next];
  float mass = a.w + b.w;
  if (mass <= 0.0) return;
  float3 edge = b.xyz - a.xyz;
  float3 correction = edge * ((1.0 - rest / max(length(edge), 1e-7)) / mass);
  s_places[at].xyz = a.xyz + correction * a.w;
  s_places[next].xyz = b.xyz - correction * b.w;
}

[numthreads(64, 1, 1)]
void sweep_lengths(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint strandsHere = 64 / max(g_vertexCount, 1);
  if (g_vertexCount < 4 || strandsHere * g_vertexCount != 64) return;
  uint vertex = lane / strandsHere;
  uint strand = group.x * strandsHere + lane % strandsHere;
  bool inside = strand < g_strandCount;
  uint index = strand * g_vertexCount + vertex;
  uint next = lane + strandsHere;
  bool hasEdge = inside && vertex + 1 < g_vertexCount;
  float rest = 0.0;
  float4 place = float4(0.0, 0.0, 0.0, 0.0);
  if (inside) {
    place = g_places[index];
    place.w = isFree(vertex, g_bind[index].w) ? 1.0 : 0.0;
    rest = g_edges[index].w;
  }
  s_places[lane] = place;
  GroupMemoryBarrierWithGroupSync();
  uint sweeps = g_restart != 0 ? 0 : g_lengthSweeps;
  for (uint sweep = 0; sweep < sweeps; ++sweep) {
    if (hasEdge && (vertex & 1) == 0) fitEdge(lane, next, rest);
    GroupMemoryBarrierWithGroupSync();
    if (hasEdge && (vertex & 1) == 1) fitEdge(lane, next, rest);
    GroupMemoryBarrierWithGroupSync();
  }
  if (!inside) return;
  uint from = hasEdge ? lane : lane - strandsHere;
  float3 edge = s_places[from + strandsHere].xyz - s_places[from].xyz;
  g_places[index] = float4(s_places[lane].xyz, g_bind[index].w);
  g_directions[index] = float4(edge / max(length(edge), 1e-12), 0.0);
}
