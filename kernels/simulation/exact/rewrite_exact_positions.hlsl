// Writes the positions of the simulated strands again from the current state: after a shift of the
// world's origin, for strands that sleep or are drawn in a pause.
//
// Threads: one per strand in the order of the state, in rows of 2^20.
// Reads:   g_rest, g_state (now), g_sleep
// Writes:  g_positions, except w
//
// Positions are summed from vertex 1, as in simulate_exact; vertex 0 is edge 0 before it. Tangents
// do not depend on the origin. interpolate_guides writes the strands beyond g_simulatedCount.
//
// Invariant (tests/simulation): with the same origin the positions are those of simulate_exact:
// vertex 0 to rounding, all others to the bit.
#include "../../base/dispatch.hlsli"
#include "exact_state.hlsli"

void rewritePosition(uint element, float3 x) {
  precise float3 world = x + g_origin.xyz;
  g_positions[element] = float4(world, g_positions[element].w);
}

[numthreads(32, 1, 1)]
void rewrite_exact_positions(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= min(g_strandCount, g_simulatedCount)) return;
  ExactStrand strand = strandAt(index);
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
