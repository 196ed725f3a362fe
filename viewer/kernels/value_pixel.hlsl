// Colors a strand by its value, without light; only where it is above g_valueAbove.
//
// Reads:   ValueVaryings, DrawValuesConstants
// Writes:  SV_Target0 linear color, opaque
//
// Invariant (tests/viewer/inspection_test): the color is that of the key in the window.
#include "draw_values.hlsli"

float4 value_pixel(ValueVaryings strand) : SV_Target0 {
  if (strand.value <= g_valueAbove) discard;
  return float4(colorOfValue(strand.value), 1.0);
}
