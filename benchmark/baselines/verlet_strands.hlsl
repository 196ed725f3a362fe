// Classic baseline, first pass: Verlet integration and global shape (sweeps_layout.hlsli).
// Threads: one a vertex. Reads g_bind, g_places, g_placesBefore; writes the last two.
#include "rotations.hlsli"
#include "sweeps_layout.hlsli"

[numthreads(64, 1, 1)]
void verlet_strands(uint3 thread : SV_DispatchThreadID) {
  uint index = thread.x;
  if (index >= g_strandCount * g_vertexCount) return;
  uint vertex = index % g_vertexCount;
  float4 bind = g_bind[index];
  float3 goal = rotate(g_rotation, bind.xyz) + g_shift.xyz;
  float3 place = g_places[index].xyz;
  float3 next = goal;
  if (g_restart != 0) {
    place = goal;
  } else if (isFree(vertex, bind.w)) {
    float3 velocity = place - g_placesBefore[index].xyz;
    next = place + velocity * (1.0 - g_damping) + g_fall.xyz;
    if (float(vertex) < g_globalRange * float(g_vertexCount))
      next += g_globalStiffness * (goal - next);
  }
  g_places[index] = float4(next, bind.w);
  g_placesBefore[index] = float4(place, bind.w);
}
