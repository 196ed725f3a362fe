// Writes strands as positions and radii, for linear swept spheres.
//
// Threads: one a vertex that is written, in rows of 2^20.
// Reads:   g_rayStrands, g_rayThickness
// Writes:  g_rayPositions, g_rayRadii
//
// Invariant (tests/ray_tracing): positions keep their bits.
#include "ray_strands.hlsli"

[numthreads(64, 1, 1)]
void write_ray_spheres(uint3 thread : SV_DispatchThreadID) {
  uint element = indexOfThread(thread);
  if (element >= g_rayElements) return;
  uint strand = element / (g_raySegments + 1u);
  uint vertex = sourceVertex(element % (g_raySegments + 1u));
  writeRayPosition(element, rayPosition(strand, vertex));
  g_rayRadii[element] = rayRadius(strand, vertex);
}
