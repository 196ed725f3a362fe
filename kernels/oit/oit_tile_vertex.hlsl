// Draws two triangles over a tile of 8 x 8 pixels, cut at the edge of the viewport.
//
// Vertices: 6, one instance per tile of the list; drawn indirectly.
// Reads:    the tile as a vertex input, OitTileConstants
#include "layouts/oit_tiles.hlsli"
#include "pixel_tiles.hlsli"

OitTilePixel oit_tile_vertex([[vk::location(0)]] uint tile : ATTRIBUTE0,
                             uint corner : SV_VertexID) {
  uint2 size = uint2(g_targetWidth, g_targetHeight);
  // Corners 0 1 2 and 2 1 3 of a square.
  uint index = corner < 3u ? corner : (corner == 3u ? 2u : (corner == 4u ? 1u : 3u));
  uint2 first = uint2(tile % g_tileColumns, tile / g_tileColumns) * kTileEdge;
  uint2 at = min(first + uint2(index & 1u, index >> 1) * kTileEdge, size);
  float2 share = float2(at) / float2(size);
  OitTilePixel result;
  result.clip = float4(share.x * 2.0 - 1.0, 1.0 - share.y * 2.0, 0.5, 1.0);
  return result;
}
