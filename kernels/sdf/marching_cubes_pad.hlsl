// Fills g_isoIndices after the last triangle with index 0, so that all of it can be drawn: the host
// does not know the number of triangles.
//
// Threads: one per triangle of the capacity, in rows of 2^20.
// Reads:   g_isoCounts
// Writes:  g_isoIndices
//
// Invariant (tests/sdf): triangles behind the last one have no area.
#include "../base/dispatch.hlsli"
#include "layouts/sdf_marching_cubes.hlsli"

[numthreads(128, 1, 1)]
void marching_cubes_pad(uint3 thread : SV_DispatchThreadID) {
  uint triangleNumber = indexOfThread(thread);
  if (triangleNumber >= g_triangleCapacity || triangleNumber < g_isoCounts[0].triangles) return;
  g_isoIndices[3u * triangleNumber] = 0u;
  g_isoIndices[3u * triangleNumber + 1u] = 0u;
  g_isoIndices[3u * triangleNumber + 2u] = 0u;
}
