// Colors the tiles that have hair by their count, over the hair, with lines between them. Tiles
// without room are striped.
//
// Reads:   g_tileCounts, DrawValuesConstants, TileCountsConstants
// Writes:  SV_Target0 linear color, premultiplied
//
// Invariant (viewer_test): a pixel of a tile without hair keeps its color.
#include "tile_counts.hlsli"

static const float kTileOpacity = 0.65;
static const float kLineDarkening = 0.5;

float4 tile_pixel(CoveringVaryings picture) : SV_Target0 {
  int2 at = int2(picture.clip.xy) - int2(g_valueArea.xy);
  if (at.x < 0 || at.y < 0 || at.x >= int(g_valueArea.z) || at.y >= int(g_valueArea.w))
    return float4(0.0, 0.0, 0.0, 0.0);
  uint2 inTile = uint2(at) & (kTileEdge - 1u);
  uint tile = (uint(at.y) >> kTileShift) * g_tileColumns + (uint(at.x) >> kTileShift);
  uint count = g_tileCounts[tile];
  if (count == 0u) return float4(0.0, 0.0, 0.0, 0.0);
  float3 color = colorOfValue(float(count));
  if (count == kTileWithoutRoom)
    color = ((inTile.x + inTile.y) & 4u) != 0u ? float3(0.6, 0.6, 0.6) : float3(0.6, 0.0, 0.4);
  if (inTile.x == 0u || inTile.y == 0u) color *= kLineDarkening;
  return float4(color * kTileOpacity, kTileOpacity);
}
