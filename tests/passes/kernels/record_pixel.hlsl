// One colour; counts the fragments of each pixel and keeps the nearest depth.
//
// One thread a fragment that passed the depth test.
// Reads constants; writes g_hits, g_depths.
// Invariant: its vertex kernel may be of a group that has the first layouts only.
#include "runtime_record.hlsli"

[earlydepthstencil]
float4 record_pixel(float4 position : SV_Position) : SV_Target0 {
  const uint pixel = pixelIndex(position);
  InterlockedAdd(g_hits[pixel], 1u);
  InterlockedMin(g_depths[pixel], asuint(position.z));
  return g_color;
}
