// Fills what is behind the last triangle with index 0, so that all of g_isoIndices can be drawn: the
// host does not know how many triangles there are.
//
// Threads: one a triangle that there is room for, in rows of 2^20.
// Reads:   g_isoCounts
// Writes:  g_isoIndices
//
// Invariant (tests/kernel): triangles behind the last one have no area.
#include "../layouts/sdf_marching_cubes.hlsli"

[numthreads(128, 1, 1)]
void marching_cubes_pad(uint3 thread : SV_DispatchThreadID) {
  uint triangleNumber = (thread.y << 20) | thread.x;
  if (triangleNumber >= g_triangleCapacity || triangleNumber < g_isoCounts[0].triangles) return;
  g_isoIndices[3u * triangleNumber] = 0u;
  g_isoIndices[3u * triangleNumber + 1u] = 0u;
  g_isoIndices[3u * triangleNumber + 2u] = 0u;
}
