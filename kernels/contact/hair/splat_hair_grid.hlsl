// Adds the mass of the guides' vertices, and their momentum, to the nodes of the grid.
//
// Threads: one for each word of two neighboring nodes a vertex, 2 or with friction 8, in rows of
//          2^20. A wave's atomics for a vertex fall into one sector of memory.
// Reads:   g_gridPositions, g_gridBefore
// Writes:  g_gridNodes, which clear_hair_grid has cleared
//
// A vertex has the mass of its Voronoi length of the strand, for all hairs that the guide
// represents; its velocity is its displacement in the last step over that step. Both go to the
// eight nodes around it with trilinear weights (Petrovic, Henne, Anderson: "Volumetric methods for
// simulation and rendering of hair", Pixar Technical Memo 06-08, 2005; McAdams et al.: "Detail
// preserving continuum simulation of straight hair", SIGGRAPH 2009). The sums are integers, so
// their order does not matter. With g_gridFriction it adds momentum as well as mass.
//
// Invariant (tests/contact): the nodes' sums are the mass and the momentum of the vertices inside,
// to half a quantum a corner; any order of the strands, and any API, gives the same bits; a vertex
// that is not finite, outside the grid or without mass adds nothing.
#include "hair_grid.hlsli"

[numthreads(64, 1, 1)]
void splat_hair_grid(uint3 thread : SV_DispatchThreadID) {
  // Lanes per vertex: the words of two nodes that are neighbors in x, and in memory.
  uint laneShift = 1u + channelShift();
  uint index = indexOfThread(thread) >> laneShift;
  uint lane = indexOfThread(thread) & ((1u << laneShift) - 1u);
  if (index >= g_gridVertexCount) return;
  GridVertex vertex = gridVertex(index);
  if (!vertex.inside) return;

  uint channel = lane & ((1u << channelShift()) - 1u);
  precise float amount = vertex.mass * g_massScale;
  if (channel > 0) {
    float3 v = vertex.velocity;
    float along = channel == 1 ? v.x : (channel == 2 ? v.y : v.z);
    amount = along * (vertex.mass * g_momentumScale);
  }
  for (uint row = 0; row < 4; ++row) {
    uint corner = 2 * row + (lane >> channelShift());
    float3 weights = weightsOf(vertex, corner);
    precise float weight = weights.x * weights.y * weights.z;
    precise float quanta = floor(amount * weight + 0.5);
    uint word = (nodeOf(vertex, corner) << channelShift()) + channel;
    if (channel == 0) {
      InterlockedAdd(g_gridNodes[word], uint(quanta));
    } else {
      InterlockedAdd(g_gridNodes[word], asuint(int(quanta)));
    }
  }
}
