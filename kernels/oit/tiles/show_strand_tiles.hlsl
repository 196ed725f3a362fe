// Draws the result of the composite.
//
// Reads:  g_picture, StrandTilesPictureConstants
// Writes: SV_Target0 premultiplied color, alpha = 1 - transmittance
#include "../layouts/oit_tiles.hlsli"
#include "../layouts/strand_tiles_picture.hlsli"
#include "../oit_tile_interface.hlsli"
#include "../../shading/strand_record.hlsli"

struct ShownPixel {
  float4 color : SV_Target0;
};

ShownPixel show_strand_tiles(OitTilePixel tile) {
  ShownPixel result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  int2 at = int2(tile.clip.xy) - int2(g_pictureX, g_pictureY);
  bool inside = at.x >= 0 && at.y >= 0 && uint(at.x) < g_pictureSize.x &&
                uint(at.y) < g_pictureSize.y;
  uint2 packed = uint2(0u, 0u);
  if (inside) packed = g_picture[uint(at.y) * g_pictureSize.x + uint(at.x)];
  if ((packed.x | packed.y) == 0u) discard;
  result.color = float4(unpackHalves(packed.x), unpackHalves(packed.y));
  return result;
}
