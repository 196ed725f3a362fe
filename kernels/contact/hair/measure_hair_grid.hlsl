// Raises the rest density of every vertex to the density of the grid at its position.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_gridPositions, g_gridBefore, g_gridNodes
// Writes:  g_gridRest
//
// The density that a vertex sees in the same shape depends on its position between the nodes: a
// single vertex sees from 1/8 to all of its own mass. So the host measures the bind pose with the
// grid at many positions and keeps the maximum density of each vertex. Pressure against that is 0
// in the bind pose wherever the object goes; pressure against a mean would push strands. The cost:
// on a coarse grid strands get packed a little more closely before they push.
//
// Invariant (tests/contact): g_gridRest only grows, and the density at a vertex is the trilinear
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
