// A triangle over the whole viewport; 3 vertices.
#include "classic_list_read_layout.hlsli"

ClassicListPixel classic_list_vertex(uint corner : SV_VertexID) {
  ClassicListPixel result;
  result.clip = float4(corner == 1u ? 3.0 : -1.0, corner == 2u ? 3.0 : -1.0, 0.5, 1.0);
  return result;
}
