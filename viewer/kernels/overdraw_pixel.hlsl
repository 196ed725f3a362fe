// Colors a pixel by its number of fragments; pixels without hair stay.
//
// Reads:   g_overdraw, DrawValuesConstants
// Writes:  SV_Target0 linear color, premultiplied
//
// Invariant (viewer_test): a pixel without fragments keeps its color.
#include "overdraw.hlsli"

float4 overdraw_pixel(CoveringVaryings picture) : SV_Target0 {
  int2 at = int2(picture.clip.xy) - int2(g_valueArea.xy);
  if (at.x < 0 || at.y < 0 || at.x >= int(g_valueArea.z) || at.y >= int(g_valueArea.w))
    return float4(0.0, 0.0, 0.0, 0.0);
  uint count = g_overdraw[uint(at.y) * uint(g_valueArea.z) + uint(at.x)];
  if (count == 0u) return float4(0.0, 0.0, 0.0, 0.0);
  return float4(colorOfValue(float(count)), 1.0);
}
