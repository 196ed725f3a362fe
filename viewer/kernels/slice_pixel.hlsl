// Colors a point of a slice by its distance from the surface of an SDF that hair can reach. Contour
// lines have equal spacing in distance; the surface is black.
//
// Reads:   g_sliceSlots, g_sliceKeys, SliceConstants
// Writes:  SV_Target0 linear color, opaque
//
// Invariant (viewer_test): without hair in reach there is no slice.
#include "slice.hlsli"
#define FIELD_SLOTS g_sliceSlots
#define FIELD_KEYS g_sliceKeys
#define FIELD_SLOT_COUNT g_sliceSlotCount
#include "field.hlsli"

float3 colorOfDistance(float distance) {
  float share = saturate((distance - g_sliceLow) / (g_sliceHigh - g_sliceLow));
  float at = share * float(kSliceColors - 1u);
  uint low = min(uint(at), kSliceColors - 2u);
  return lerp(g_sliceRamp[low].rgb, g_sliceRamp[low + 1u].rgb, at - float(low));
}

float4 slice_pixel(SliceVaryings slice) : SV_Target0 {
  Sdf sdf;
  if (!findField(g_sliceOrigin, g_sliceNodes, sdf)) discard;
  float distance = fieldDistance(sdf, slice.world);
  // A distance changes by at most the displacement; fwidth(distance) would jump at the grid's end.
  float3 step = fwidth(slice.world);
  float pixel = length(step) * 0.7;
  if (distance > 1e17) discard;
  float3 color = colorOfDistance(distance);
  float contour = abs(distance / g_sliceLine - floor(distance / g_sliceLine + 0.5)) * g_sliceLine;
  if (contour < 0.5 * pixel && abs(distance) < g_sliceHigh) color *= 0.75;
  if (abs(distance) < 0.8 * pixel) color = float3(0.0, 0.0, 0.0);
  return float4(color, 1.0);
}
