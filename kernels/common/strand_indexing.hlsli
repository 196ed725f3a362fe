// Where things are in the buffers of layouts/simulation.hlsli, and how threads map to them.
#ifndef PELAGE_COMMON_STRAND_INDEXING_HLSLI
#define PELAGE_COMMON_STRAND_INDEXING_HLSLI

#include "../layouts/simulation.hlsli"

// Vertices a strand may have; a loop over a count that is out of range would not end.
static const uint kMinVertices = 2;
static const uint kMaxVertices = 256;

// Set 0 or 1 of g_state or g_rest.
uint guideIndex(uint set, uint vertex, uint guide) {
  return (set * g_vertexCount + vertex) * g_guideCount + guide;
}

// Of g_positions and g_tangents.
uint vertexIndex(uint strand, uint vertex) { return strand * g_vertexCount + vertex; }

#endif
