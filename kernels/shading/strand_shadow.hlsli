// Light that hair transmits, from a shadow map, for the project's kernels and for an engine's own;
// no resources. The including file first defines
//   SHADOW_WORDS   the buffer of the maps' words, a StructuredBuffer<uint>
// shading/layouts/strand_shadow_view.hlsli says what is in it.
//
// With layers, a texel's optical depth at a distance behind its nearest hair is interpolated
// linearly between the ends of the layer (Yuksel and Keyser, "Deep opacity maps", Eurographics
// 2008). Without layers, hair has its mean density: (1 - a)^(distance / spacing), for fibers of
// opacity a that a ray hits every `spacing` meters, is exp(-extinction distance) with extinction =
// -ln(1 - a) / spacing. Both use only lengths in meters: scaling the scene does not change them.
#ifndef PELAGE_SHADING_STRAND_SHADOW_HLSLI
#define PELAGE_SHADING_STRAND_SHADOW_HLSLI

#include "shadow_faces.hlsli"

// Returns the optical depth of the texel at (x, y) up to a distance behind the near plane [m].
float opticalDepthAt(StrandShadowView map, int x, int y, float depth) {
  if (min(x, y) < 0 || x >= int(map.width) || y >= int(map.height)) return 0.0;
  uint texel = uint(y) * map.width + uint(x);
  uint nearest = SHADOW_WORDS[map.firstWord + texel];
  if (nearest == kNoHair) return 0.0;
  float behind = depth - map.bias - asfloat(nearest);
  if (!(behind > 0.0)) return 0.0;
  if (map.layerCount == 0u) return behind * map.extinction;

  float layers = float(map.layerCount);
  float layer = min(floor(sqrt(behind / map.layerRange) * layers), layers - 1.0);
  float2 ends = float2(layer, layer + 1.0) / layers;
  ends = ends * ends * map.layerRange;
  float share = saturate((behind - ends.x) / (ends.y - ends.x));
  uint last = firstLayerOf(map, texel) + uint(layer);
  float low = 0.0;
  if (layer > 0.0) low = float(SHADOW_WORDS[last - 1u]);
  float high = float(SHADOW_WORDS[last]);
  return (low + (high - low) * share) * map.tauQuantum;
}

// Returns the share 0..1 of the light that hair in front of a point transmits to it; 1 outside the
// map, and for a position that is not finite.
float strandTransmittance(StrandShadowView map, float3 position) {
  float4 p = float4(position, 1.0);
  float4 at = float4(dot(map.mapX, p), dot(map.mapY, p), dot(map.mapZ, p), dot(map.mapW, p));
  uint face = shadowFaceOf(map, at);
  at = onShadowFace(map, face, at);
  map = shadowFace(map, face);
  if (!(at.w >= map.nearW)) return 1.0;
  float2 texel = at.xy / at.w - 0.5;
  float depth = at.z;
  float2 size = float2(float(map.width), float(map.height));
  // NaN fails these tests, too.
  if (!(min(texel.x, texel.y) > -1.0) || !(texel.x < size.x) || !(texel.y < size.y)) return 1.0;
  if (!(depth > 0.0) || !(depth < 1e30)) return 1.0;
  map.bias *= at.w;
  if (isProjective(map)) {
    // The distance along a ray is longer than that along the axis.
    float2 slope = (texel + 0.5 - 0.5 * size) * map.texelSize;
    map.extinction *= sqrt(1.0 + dot(slope, slope));
  }

  float2 lowest = floor(texel);
  float2 share = texel - lowest;
  int x = int(lowest.x);
  int y = int(lowest.y);
  float4 tau =
      float4(opticalDepthAt(map, x, y, depth), opticalDepthAt(map, x + 1, y, depth),
             opticalDepthAt(map, x, y + 1, depth), opticalDepthAt(map, x + 1, y + 1, depth));
  float2 rows = tau.xz + (tau.yw - tau.xz) * share.x;
  return exp(-max(rows.x + (rows.y - rows.x) * share.y, 0.0));
}

#endif
