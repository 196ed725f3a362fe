// A rectangle in the world, as a strip of 4 vertices.
//
// One thread a vertex. Reads SliceConstants, writes SliceVaryings.
// Invariant: corner i is the first one, with an edge more along each axis of its bits.
#include "slice.hlsli"

SliceVaryings slice_vertex(uint corner : SV_VertexID) {
  SliceVaryings result;
  result.world = g_sliceCorner.xyz + g_sliceAcross.xyz * float(corner & 1u) +
                 g_sliceUp.xyz * float(corner >> 1);
  float4 p = float4(result.world, 1.0);
  result.clip = float4(dot(g_sliceToClip[0], p), dot(g_sliceToClip[1], p), dot(g_sliceToClip[2], p),
                       dot(g_sliceToClip[3], p));
  return result;
}
