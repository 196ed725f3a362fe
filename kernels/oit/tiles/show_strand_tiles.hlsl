// Draws the result of the composite.
//
// Reads:  g_picture, StrandTilesPictureConstants
// Writes: SV_Target0 premultiplied color, alpha = 1 - transmittance
#include "../layouts/oit_tiles.hlsli"
#include "../../shading/strand_record.hlsli"

cbuffer StrandTilesPictureConstants : register(b0, space1) {
  int g_pictureX;  // of the viewport [pixels]
  int g_pictureY;
  uint2 g_pictureSize;  // [pixels]
};

// As g_tilePicture in strand_tiles_composite.hlsli.
StructuredBuffer<uint2> g_picture : register(t0, space1);

struct ShownPixel {
  float4 color : SV_Target0;
};

ShownPixel show_strand_tiles(OitTilePixel tile) {
  ShownPixel result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  int2 at = int2(tile.clip.xy) - int2(g_pictureX, g_pictureY);
  bool inside =
      at.x >= 0 && at.y >= 0 && uint(at.x) < g_pictureSize.x && uint(at.y) < g_pictureSize.y;
  uint2 packed = uint2(0u, 0u);
  if (inside) packed = g_picture[uint(at.y) * g_pictureSize.x + uint(at.x)];
  if ((packed.x | packed.y) == 0u) discard;
  result.color = float4(unpackHalves(packed.x), unpackHalves(packed.y));
  return result;
}
