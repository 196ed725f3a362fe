// Draws triangles whose clip positions are in a buffer.
//
// One thread a vertex.
// Reads g_corners.
// Invariant: y = 1 is the top row of the image on every API.
#include "runtime_draw.hlsli"

float4 fill_vertex(uint vertex : SV_VertexID) : SV_Position { return g_corners[vertex] + g_offset; }
