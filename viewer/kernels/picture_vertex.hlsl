// A triangle that covers the picture.
//
// One thread a vertex. Reads nothing, writes its varyings.
// Invariant: every pixel of the viewport is inside.
#include "picture.hlsli"

PictureVaryings picture_vertex(uint corner : SV_VertexID) {
  PictureVaryings result;
  float x = corner == 1u ? 3.0 : -1.0;
  float y = corner == 2u ? 3.0 : -1.0;
  result.clip = float4(x, y, 0.5, 1.0);
  return result;
}
