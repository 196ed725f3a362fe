// A triangle that covers the viewport.
//
// One thread a vertex. Reads nothing, writes OverdrawVaryings.
// Invariant: every pixel of the viewport is inside.
#include "overdraw.hlsli"

OverdrawVaryings overdraw_vertex(uint corner : SV_VertexID) {
  OverdrawVaryings result;
  result.clip = float4(corner == 1u ? 3.0 : -1.0, corner == 2u ? 3.0 : -1.0, 0.5, 1.0);
  return result;
}
