// Writes the positions of the guides again from the current state: after a shift of the world's
// origin, for hair that is drawn before it is simulated again.
//
// Threads: one per vertex of the guides, strand fastest, in rows of 2^20.
// Reads:   g_state (current)
// Writes:  g_positions of the guides, except w
//
// Invariant (tests/simulation): with the same origin the positions are those of simulate_classic to
// the bit.
#include "../../base/dispatch.hlsli"
#include "../strand_indexing.hlsli"

[numthreads(64, 1, 1)]
void rewrite_classic_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices || g_guideCount == 0u) return;
  uint vertex = index / g_guideCount;
  if (vertex >= g_vertexCount) return;
  uint guide = index - vertex * g_guideCount;
  precise float3 world = g_state[guideIndex(0, vertex, guide)].xyz + g_origin.xyz;
  uint element = vertexIndex(guide, vertex);
  g_positions[element] = float4(world, g_positions[element].w);
}
