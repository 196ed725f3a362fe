// Light that opaque geometry lets through to hair, from a depth map of an engine's; no resources.
// The including file first defines
//   SHADOW_WORDS   the buffer of the maps' words, a StructuredBuffer<uint>
//
// The four texels around a point are compared and the results are interpolated (percentage closer
// filtering: Reeves, Salesin and Cook, "Rendering antialiased shadows with depth maps", 1987).
// Invariant (tests/shadow/opaque_shadow_test): 0 inside of a silhouette and 1 outside of it, half a
// texel around its edge in between.
#ifndef PELAGE_SHADING_OPAQUE_SHADOW_HLSLI
#define PELAGE_SHADING_OPAQUE_SHADOW_HLSLI

#include "layouts/opaque_shadow_view.hlsli"

// Returns whether light passes the texel at (x, y) up to a depth, 0 or 1; 1 outside the map, where
// there is nothing, and for a depth in the map that is NaN.
float opaqueLightAt(OpaqueShadowView map, int x, int y, float depth) {
  bool inside = min(x, y) >= 0 && x < int(map.width) && y < int(map.height);
  uint texel = inside ? uint(y) * map.width + uint(x) : 0u;
  float nearest = asfloat(SHADOW_WORDS[map.firstWord + texel]);
  bool covered =
      map.reversedDepth != 0u ? nearest > 0.0 && depth < nearest : nearest < 1.0 && depth > nearest;
  return inside && covered ? 0.0 : 1.0;
}

// Returns the share 0..1 of the light that opaque geometry lets through to a point; 1 outside the
// map, and for a position that is not finite. \param toLight unit vector
float opaqueTransmittance(OpaqueShadowView map, float3 position, float3 toLight) {
  float4 p = float4(position + toLight * map.bias, 1.0);
  float w = dot(map.clipW, p);
  if (!(w > 0.0)) return 1.0;
  float3 clip = float3(dot(map.clipX, p), dot(map.clipY, p), dot(map.clipZ, p)) / w;
  float2 size = float2(float(map.width), float(map.height));
  float2 texel = float2(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y) * size - 0.5;
  // On the bits, because a driver may assume that no float is a NaN: below 1e30.
  if (asuint(abs(texel.x) + abs(texel.y) + abs(clip.z)) >= 0x7149f2cau) return 1.0;
  if (min(texel.x, texel.y) <= -1.0 || texel.x >= size.x || texel.y >= size.y) return 1.0;

  float2 lowest = floor(texel);
  float2 share = texel - lowest;
  int x = int(lowest.x);
  int y = int(lowest.y);
  float4 light =
      float4(opaqueLightAt(map, x, y, clip.z), opaqueLightAt(map, x + 1, y, clip.z),
             opaqueLightAt(map, x, y + 1, clip.z), opaqueLightAt(map, x + 1, y + 1, clip.z));
  float2 rows = light.xz + (light.yw - light.xz) * share.x;
  return rows.x + (rows.y - rows.x) * share.y;
}

#endif
