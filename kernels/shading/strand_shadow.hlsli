// Light that hair transmits, from a shadow map, for the project's kernels and for an engine's own;
// no resources. The including file first defines
//   SHADOW_WORDS   the buffer of the maps' words, a StructuredBuffer<uint>
// shading/layouts/strand_shadow_view.hlsli says what is in it.
//
// Light is interpolated between the four texels around a point.
// With layers, a texel's optical depth at a distance behind its nearest hair is interpolated
// linearly between the ends of the layer (Yuksel and Keyser, "Deep opacity maps", Eurographics
// 2008). Without layers, hair has its mean density: (1 - a)^(distance / spacing), for fibers of
// opacity a that a ray hits every `spacing` meters, is exp(-extinction distance) with extinction =
// -ln(1 - a) / spacing. Both use only lengths in meters: scaling the scene does not change them.
#ifndef PELAGE_SHADING_STRAND_SHADOW_HLSLI
#define PELAGE_SHADING_STRAND_SHADOW_HLSLI

#include "shadow_faces.hlsli"
#include "strand_light_path.hlsli"

// Returns the optical depth of the texel at (x, y) up to a distance behind the near plane [m], and
// in y that of all its hair.
float2 opticalDepthsAt(StrandShadowView map, int x, int y, float depth) {
  if (min(x, y) < 0 || x >= int(map.width) || y >= int(map.height)) return float2(0.0, 0.0);
  uint texel = uint(y) * map.width + uint(x);
  uint nearest = SHADOW_WORDS[map.firstWord + texel];
  if (nearest == kNoHair) return float2(0.0, 0.0);
  float behind = depth - map.bias - asfloat(nearest);
  if (map.layerCount == 0u) {
    // Where hair ends is not known.
    float front = max(behind, 0.0) * map.extinction;
    return float2(front, front + kEndlessHair);
  }

  uint firstLayer = firstLayerOf(map, texel);
  float all = float(SHADOW_WORDS[firstLayer + map.layerCount - 1u]) * map.tauQuantum;
  if (!(behind > 0.0)) return float2(0.0, all);
  float layers = float(map.layerCount);
  float layer = min(floor(sqrt(behind / map.layerRange) * layers), layers - 1.0);
  float2 ends = float2(layer, layer + 1.0) / layers;
  ends = ends * ends * map.layerRange;
  float share = saturate((behind - ends.x) / (ends.y - ends.x));
  uint last = firstLayer + uint(layer);
  float low = 0.0;
  if (layer > 0.0) low = float(SHADOW_WORDS[last - 1u]);
  float high = float(SHADOW_WORDS[last]);
  return float2((low + (high - low) * share) * map.tauQuantum, all);
}

// Returns what is on the light's ray through a point: no hair outside the map, and for a position
// that is not finite.
StrandLightPath strandLightPath(StrandShadowView map, float3 position) {
  StrandLightPath path;
  path.known = false;
  path.transmittance = 1.0;
  path.front = 0.0;
  path.behind = 0.0;
  path.across = map.across;
  float4 p = float4(position, 1.0);
  float4 at = float4(dot(map.mapX, p), dot(map.mapY, p), dot(map.mapZ, p), dot(map.mapW, p));
  uint face = shadowFaceOf(map, at);
  at = onShadowFace(map, face, at);
  map = shadowFace(map, face);
  if (!(at.w >= map.nearW)) return path;
  float2 texel = at.xy / at.w - 0.5;
  float depth = at.z;
  float2 size = float2(float(map.width), float(map.height));
  // NaN fails these tests, too.
  if (!(min(texel.x, texel.y) > -1.0) || !(texel.x < size.x) || !(texel.y < size.y)) return path;
  if (!(depth > 0.0) || !(depth < 1e30)) return path;
  path.known = true;
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
  float2 a = opticalDepthsAt(map, x, y, depth);
  float2 b = opticalDepthsAt(map, x + 1, y, depth);
  float2 c = opticalDepthsAt(map, x, y + 1, depth);
  float2 d = opticalDepthsAt(map, x + 1, y + 1, depth);
  // Light is interpolated, not the depth: next to dense hair the mean of depths would be dark up to
  // the middle of the texel that has none.
  float4 light = exp(-float4(a.x, b.x, c.x, d.x));
  float2 rows = light.xz + (light.yw - light.xz) * share.x;
  path.transmittance = saturate(rows.x + (rows.y - rows.x) * share.y);
  path.front = -log(max(path.transmittance, 1e-28));
  float4 behind = float4(a.y - a.x, b.y - b.x, c.y - c.x, d.y - d.x);
  rows = behind.xz + (behind.yw - behind.xz) * share.x;
  path.behind = max(rows.x + (rows.y - rows.x) * share.y, 0.0);
  return path;
}

// Returns the share 0..1 of the light that hair in front of a point transmits to it; 1 outside the
// map, and for a position that is not finite.
float strandTransmittance(StrandShadowView map, float3 position) {
  return strandLightPath(map, position).transmittance;
}

// Returns the mean of strandTransmittance() over a disc around a point that faces the light: the soft
// edge of a light that is not a point, or of light that spreads under skin. \param radius [m]
float softTransmittance(StrandShadowView map, float3 position, float3 toLight, float radius) {
  // A sunflower's points: each has the same part of the disc (Vogel, "A better way to construct the
  // sunflower head", 1979).
  static const uint kPoints = 12u;
  static const float kGoldenAngle = 2.3999632;
  float3 axis = abs(toLight.y) < 0.9 ? float3(0.0, 1.0, 0.0) : float3(1.0, 0.0, 0.0);
  float3 x = normalize(cross(axis, toLight));
  float3 y = cross(toLight, x);
  float sum = 0.0;
  for (uint i = 0u; i < kPoints; ++i) {
    float distance = radius * sqrt((float(i) + 0.5) / float(kPoints));
    float angle = kGoldenAngle * float(i);
    sum += strandTransmittance(map, position + (x * cos(angle) + y * sin(angle)) * distance);
  }
  return sum / float(kPoints);
}

#endif
