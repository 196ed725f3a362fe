// Indices into the buffers of simulation/layouts/simulation.hlsli.
#ifndef PELAGE_SIMULATION_STRAND_INDEXING_HLSLI
#define PELAGE_SIMULATION_STRAND_INDEXING_HLSLI

#include "layouts/simulation.hlsli"

// Maximum vertices per strand; a loop over a count that is out of range would not end.
static const uint kMinVertices = 2;
static const uint kMaxVertices = 256;

// Returns the element of a vertex in a set of g_state or g_rest.
uint guideIndex(uint set, uint vertex, uint guide) {
  return (set * g_vertexCount + vertex) * g_guideCount + guide;
}

// Returns the element of a vertex in g_positions and g_tangents.
uint vertexIndex(uint strand, uint vertex) { return strand * g_vertexCount + vertex; }

#endif
