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
// in y that of all its hair. Reads of several texels do not wait for each other: no branch depends
// on what was read.
float2 opticalDepthsAt(StrandShadowView map, int x, int y, float depth) {
  bool inside = min(x, y) >= 0 && x < int(map.width) && y < int(map.height);
  uint texel = inside ? uint(y) * map.width + uint(x) : 0u;
  uint nearest = SHADOW_WORDS[map.firstWord + texel];
  bool hasHair = inside && nearest != kNoHair;
  float behind = hasHair ? max(depth - map.bias - asfloat(nearest), 0.0) : 0.0;
  bool layered = map.layerCount != 0u;
  uint firstLayer = layered ? firstLayerOf(map, texel) : map.firstWord;
  uint count = max(map.layerCount, 1u);
  float layers = float(count);
  float layer = layered ? min(floor(sqrt(behind / map.layerRange) * layers), layers - 1.0) : 0.0;
  float2 ends = float2(layer, layer + 1.0) / layers;
  ends = ends * ends * map.layerRange;
  float share = saturate((behind - ends.x) / (ends.y - ends.x));
  uint last = firstLayer + uint(layer);
  float all = float(SHADOW_WORDS[firstLayer + count - 1u]) * map.tauQuantum;
  float low = layer > 0.0 ? float(SHADOW_WORDS[max(last, 1u) - 1u]) : 0.0;
  float high = float(SHADOW_WORDS[last]);
  float front = (low + (high - low) * share) * map.tauQuantum;
  if (!layered) {
    // Where hair ends is not known.
    front = behind * map.extinction;
    all = front + kEndlessHair;
  }
  return hasHair ? float2(behind > 0.0 ? front : 0.0, all) : float2(0.0, 0.0);
}

// Where a point is in a map.
struct ShadowPoint {
  bool known;            // false: outside the map, or not finite
  StrandShadowView map;  // of its face
  float2 texel;          // 0 at the middle of the first
  float depth;           // behind the near plane [m]
};

ShadowPoint shadowPoint(StrandShadowView map, float3 position) {
  ShadowPoint place;
  place.known = false;
  place.texel = float2(0.0, 0.0);
  float4 p = float4(position, 1.0);
  float4 at = float4(dot(map.mapX, p), dot(map.mapY, p), dot(map.mapZ, p), dot(map.mapW, p));
  uint face = shadowFaceOf(map, at);
  at = onShadowFace(map, face, at);
  place.map = shadowFace(map, face);
  place.depth = at.z;
  place.texel = at.xy / at.w - 0.5;
  float2 size = float2(float(map.width), float(map.height));
  // NaN fails these tests, too.
  place.known = at.w >= map.nearW && min(place.texel.x, place.texel.y) > -1.0 &&
                place.texel.x < size.x && place.texel.y < size.y && place.depth > 0.0 &&
                place.depth < 1e30;
  place.map.bias *= at.w;
  if (isProjective(map)) {
    // The distance along a ray is longer than that along the axis.
    float2 slope = (place.texel + 0.5 - 0.5 * size) * map.texelSize;
    place.map.extinction *= sqrt(1.0 + dot(slope, slope));
  }
  return place;
}

// Returns what is on the light's ray through a point: openLightPath() outside the map, and for a
// position that is not finite.
StrandLightPath strandLightPath(StrandShadowView map, float3 position) {
  StrandLightPath path = openLightPath();
  ShadowPoint place = shadowPoint(map, position);
  path.known = place.known;
  if (!place.known) return path;
  path.across = map.across;

  float2 lowest = floor(place.texel);
  float2 share = place.texel - lowest;
  int x = int(lowest.x);
  int y = int(lowest.y);
  float2 a = opticalDepthsAt(place.map, x, y, place.depth);
  float2 b = opticalDepthsAt(place.map, x + 1, y, place.depth);
  float2 c = opticalDepthsAt(place.map, x, y + 1, place.depth);
  float2 d = opticalDepthsAt(place.map, x + 1, y + 1, place.depth);
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

// Returns the mean of this share over five points, 4 texels from side to side: shadows on skin have
// soft edges, as light spreads under it.
float softTransmittance(StrandShadowView map, float3 position) {
  ShadowPoint place = shadowPoint(map, position);
  if (!place.known) return 1.0;
  float2 middle = place.texel + 0.5;
  float sum = 0.0;
  [unroll] for (uint i = 0u; i < 5u; ++i) {
    // A square that is turned, so that no two points cross into other texels together.
    float2 offset = float2(0.0, 0.0);
    if (i == 1u) offset = float2(1.8, 0.7);
    if (i == 2u) offset = float2(-0.7, 1.8);
    if (i == 3u) offset = float2(-1.8, -0.7);
    if (i == 4u) offset = float2(0.7, -1.8);
    int2 at = int2(floor(middle + offset));
    sum += exp(-opticalDepthsAt(place.map, at.x, at.y, place.depth).x);
  }
  return sum / 5.0;
}

#endif
