// Raises the rest density of every vertex to the density that the grid has there.
//
// Threads: one a vertex, in rows of 2^20.
// Reads:   g_gridPositions, g_gridBefore, g_gridNodes
// Writes:  g_gridRest
//
// The density that a vertex sees in one and the same shape depends on where between the nodes it
// is: one alone sees from 1/8 to all of its own mass. So the host measures the bind pose with the
// grid in many places and keeps the largest density of each vertex. Pressure against that is 0 in
// the bind pose wherever the object goes; a mean would push strands about that rest. What a coarse
// grid leaves uncertain goes into strands being packed a little more closely before they push.
//
// Invariant (tests/kernel): g_gridRest only grows, and the density at a vertex is the trilinear
// interpolation of the nodes' mass.
#include "hair_grid.hlsli"

[numthreads(64, 1, 1)]
void measure_hair_grid(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_gridVertexCount) return;
  GridVertex vertex = gridVertex(index);
  if (!vertex.inside) return;
  precise float density = 0.0;
  for (uint corner = 0; corner < 8; ++corner) {
    float3 weights = weightsOf(vertex, corner);
    precise float weight = weights.x * weights.y * weights.z;
    density = density + float(g_gridNodes[nodeOf(vertex, corner)]) * weight;
  }
  g_gridRest[index] = max(g_gridRest[index], density);
}
