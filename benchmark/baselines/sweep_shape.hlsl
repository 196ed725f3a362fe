// Classic baseline: local shape (sweeps_layout.hlsli). From root to tip each edge goes a share of
// the way to its rest vector in the frame of the edge before, and both its ends move.
// Threads: one a strand. Reads g_bind, g_edges, g_places; writes g_places.
#include "rotations.hlsli"
#include "sweeps_layout.hlsli"

[numthreads(64, 1, 1)]
void sweep_shape(uint3 thread : SV_DispatchThreadID) {
  uint strand = thread.x;
  if (strand >= g_strandCount || g_restart != 0 || g_vertexCount < 3) return;
  uint first = strand * g_vertexCount;
  float4 rootFrame = product(g_rotation, g_edges[first + g_vertexCount - 1]);
  float share = 0.5 * min(g_localStiffness, 0.95);
  uint sweeps = g_vertexCount >= 64 ? 1 : g_shapeSweeps;
  for (uint sweep = 0; sweep < sweeps; ++sweep) {
    float4 frame = rootFrame;
    float4 p = g_places[first + 1];
    for (uint i = 1; i + 1 < g_vertexCount; ++i) {
      float4 q = g_places[first + i + 1];
      float3 correction = share * (p.xyz + rotate(frame, g_edges[first + i].xyz) - q.xyz);
      if (isFree(i, p.w)) p.xyz -= correction;
      if (isFree(i + 1, q.w)) q.xyz += correction;
      g_places[first + i] = p;
      float3 edge = q.xyz - p.xyz;
      float size = length(edge);
      if (size > 1e-7) {
        float3 local = rotate(conjugate(frame), edge / size);
        frame = normalize(product(frame, rotationBetween(float3(1.0, 0.0, 0.0), local)));
      }
      p = q;
    }
    g_places[first + g_vertexCount - 1] = p;
  }
}
