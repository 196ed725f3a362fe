// Writes the positions of the simulated strands once more, from the state as it is: after a shift of
// the world's origin, for strands that sleep or are drawn in a pause.
//
// Threads: one a strand in the order of g_strands, in rows of 2^20.
// Reads:   g_strands, g_rest, g_state (now), g_sleep
// Writes:  g_positions but for w
//
// They are summed from vertex 1 as simulate_rods does; vertex 0 is edge 0 before it. Tangents do not
// depend on the origin. Strands beyond g_simulatedCount are those of interpolate_guides.
//
// Invariant (tests/kernel): with the same origin the positions are those of simulate_rods, vertex 0
// to rounding, all others to the bit.
#include "rod_state.hlsli"

void rewritePosition(uint element, float3 x) {
  precise float3 world = x + g_origin.xyz;
  g_positions[element] = float4(world, g_positions[element].w);
}

[numthreads(32, 1, 1)]
void rewrite_exact_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = (thread.y << 20) | thread.x;
  if (index >= min(g_strandCount, g_simulatedCount)) return;
  ExactStrand strand = g_strands[index];
  if (!isSound(strand) || !fitsOutputs(strand)) return;

  Slots slots = slotsOfTile(index / kTileStrands);
  uint tip = strand.count - 1;
  float4 frame = g_state[stateIndex(kFrameSets + slots.now, 0, strand)];
  precise float3 edge = axisX(frame) * g_rest[stateIndex(0, tip, strand)].x;
  precise float3 x = g_state[strandIndex(kFirstPosition, slots.now, index)].xyz;
  precise float3 root = x - edge;
  rewritePosition(strand.target, root);
  [loop] for (uint i = 1; i < tip; ++i) {
    rewritePosition(strand.target + i, x);
    float edgeLength = g_rest[stateIndex(0, i, strand)].z;
    precise float3 tangent = axisX(g_state[stateIndex(kFrameSets + slots.now, i, strand)]);
    x = x + tangent * edgeLength;
  }
  for (uint v = tip; v < max(strand.count, g_outputVertices); ++v)
    rewritePosition(strand.target + v, x);
}
