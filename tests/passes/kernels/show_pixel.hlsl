// Shows what earlier lists left in the buffers: (fragments, depth, 0, 1).
//
// One thread a fragment.
// Reads g_hits, g_depths.
// Invariant: the picture is the buffers.
#include "runtime_record.hlsli"

float4 show_pixel(float4 position : SV_Position) : SV_Target0 {
  const uint pixel = pixelIndex(position);
  return float4(float(g_hits[pixel]), asfloat(g_depths[pixel]), 0.0, 1.0);
}
