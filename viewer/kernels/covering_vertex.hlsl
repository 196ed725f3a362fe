// A triangle that covers the viewport.
//
// One thread a vertex. Reads nothing, writes CoveringVaryings.
// Invariant: every pixel of the viewport is inside.
#include "draw_values.hlsli"

CoveringVaryings covering_vertex(uint corner : SV_VertexID) {
  CoveringVaryings result;
  result.clip = float4(corner == 1u ? 3.0 : -1.0, corner == 2u ? 3.0 : -1.0, 0.5, 1.0);
  return result;
}
