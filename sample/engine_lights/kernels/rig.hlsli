// The light of this engine: a sun with cascaded shadow maps, a spot light with a shadow map, and
// the light of the sky in an irradiance cube. Nothing of it is pelage's. Who includes this defines
// RIG_SPACE before.
#ifndef ENGINE_LIGHTS_RIG_HLSLI
#define ENGINE_LIGHTS_RIG_HLSLI

static const uint kRigCascades = 3u;

cbuffer EngineRig : register(b0, RIG_SPACE) {
  float4 g_rigSun;           // xyz unit vector towards the sun
  float4 g_rigSunColor;      // linear rgb, in pelage's unit; so are the other colors
  float4 g_rigCascades[9];   // [cascade][3] rows: world to u, v and depth 0..1; the smallest first
  float4 g_rigSpot[4];       // rows: world to clip of the spot light's map
  float4 g_rigSpotPosition;  // xyz [m]; w cosine of the angle at the edge of its cone
  float4 g_rigSpotAxis;      // xyz unit vector away from it; w cosine where it begins to fall off
  float4 g_rigSpotColor;     // at 1 m
  float4 g_rigSky;           // x factor on the light of the cube
  float4 g_rigMaps;          // texels an edge: x of a cascade, y of the spot's map; bias in their
                             // depths: z, w
};

// Depths 0..1 of opaque geometry, seen from the lights.
Texture2DArray<float> g_rigCascadeMaps : register(t0, RIG_SPACE);  // [cascade]
Texture2DArray<float> g_rigSpotMap : register(t1, RIG_SPACE);      // [0]
TextureCube<float4> g_rigIrradiance : register(t2, RIG_SPACE);
SamplerState g_rigIrradianceSampler : register(s2, RIG_SPACE);

// The four texels around a position, as bilinear comparison has them: xy the one at the upper left,
// zw the shares of the right and of the lower ones.
float4 comparedTexels(float2 uv, float size) {
  float2 texel = uv * size - 0.5;
  float2 low = floor(texel);
  return float4(low, texel - low);
}

int3 texelAt(float4 compared, int x, int y, uint layer, float size) {
  int2 texel = int2(compared.xy) + int2(x, y);
  return int3(clamp(texel, int2(0, 0), int2(int(size) - 1, int(size) - 1)), int(layer));
}

float mixedTexels(float4 open, float2 share) {
  float2 rows = lerp(open.xz, open.yw, share.x);
  return lerp(rows.x, rows.y, share.y);
}

float isOpen(float depth, float nearest) { return depth <= nearest ? 1.0 : 0.0; }

float openInCascade(uint cascade, float3 at) {
  float4 texels = comparedTexels(at.xy, g_rigMaps.x);
  float depth = at.z - g_rigMaps.z;
  float4 open;
  open.x =
      isOpen(depth, g_rigCascadeMaps.Load(int4(texelAt(texels, 0, 0, cascade, g_rigMaps.x), 0)));
  open.y =
      isOpen(depth, g_rigCascadeMaps.Load(int4(texelAt(texels, 1, 0, cascade, g_rigMaps.x), 0)));
  open.z =
      isOpen(depth, g_rigCascadeMaps.Load(int4(texelAt(texels, 0, 1, cascade, g_rigMaps.x), 0)));
  open.w =
      isOpen(depth, g_rigCascadeMaps.Load(int4(texelAt(texels, 1, 1, cascade, g_rigMaps.x), 0)));
  return mixedTexels(open, texels.zw);
}

// Share of the sun that opaque geometry lets through, 0..1; 1 outside of all cascades. The smallest
// cascade that has the position is chosen without leaving the loop.
float sunVisibility(float3 world) {
  float4 p = float4(world, 1.0);
  uint smallest = kRigCascades;
  float3 position = float3(0.0, 0.0, 0.0);
  [unroll] for (uint i = 0u; i < kRigCascades; ++i) {
    uint cascade = kRigCascades - 1u - i;
    float3 at =
        float3(dot(g_rigCascades[3u * cascade], p), dot(g_rigCascades[3u * cascade + 1u], p),
               dot(g_rigCascades[3u * cascade + 2u], p));
    bool inside = all(at == saturate(at));
    smallest = inside ? cascade : smallest;
    position = inside ? at : position;
  }
  float open = openInCascade(min(smallest, kRigCascades - 1u), position);
  return smallest < kRigCascades ? open : 1.0;
}

struct SpotLight {
  float3 toLight;  // unit
  float3 color;    // that arrives, with its shadow
};

SpotLight spotAt(float3 world) {
  SpotLight spot;
  float3 offset = g_rigSpotPosition.xyz - world;
  float distanceSquared = max(dot(offset, offset), 1e-4);
  spot.toLight = offset * rsqrt(distanceSquared);
  float cosine = dot(-spot.toLight, g_rigSpotAxis.xyz);
  float share = saturate((cosine - g_rigSpotPosition.w) / (g_rigSpotAxis.w - g_rigSpotPosition.w));
  spot.color = g_rigSpotColor.rgb * (share * share / distanceSquared);
  float4 p = float4(world, 1.0);
  // Points behind the spot light get none of it.
  float w = max(dot(g_rigSpot[3], p), 1e-6);
  float2 clip = float2(dot(g_rigSpot[0], p), dot(g_rigSpot[1], p)) / w;
  float depth = dot(g_rigSpot[2], p) / w - g_rigMaps.w;
  float2 uv = saturate(float2(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y));
  float4 texels = comparedTexels(uv, g_rigMaps.y);
  float4 open;
  open.x = isOpen(depth, g_rigSpotMap.Load(int4(texelAt(texels, 0, 0, 0u, g_rigMaps.y), 0)));
  open.y = isOpen(depth, g_rigSpotMap.Load(int4(texelAt(texels, 1, 0, 0u, g_rigMaps.y), 0)));
  open.z = isOpen(depth, g_rigSpotMap.Load(int4(texelAt(texels, 0, 1, 0u, g_rigMaps.y), 0)));
  open.w = isOpen(depth, g_rigSpotMap.Load(int4(texelAt(texels, 1, 1, 0u, g_rigMaps.y), 0)));
  spot.color *= mixedTexels(open, texels.zw);
  return spot;
}

// Light of the sky and the surroundings on a white surface that faces this way. Without
// derivatives: the kernels that call it do so in loops and in compute.
float3 skyOn(float3 normal) {
  return g_rigIrradiance.SampleLevel(g_rigIrradianceSampler, normal, 0.0).rgb * g_rigSky.x;
}

#endif
