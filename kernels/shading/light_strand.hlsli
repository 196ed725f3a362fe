// The light that a strand sends to the eye, as every transparency method takes it. The including
// file has a layout with strand_view.hlsli and defines SHADOW_WORDS, the buffer of the shadow maps.
//
// With ENGINE_LIGHTS_SPACE the light is an engine's own: pelage_add_engine_lights() defines it, and
// includes the engine's file behind the kernel. docs/shading.md has the contract.
#ifndef PELAGE_SHADING_LIGHT_STRAND_HLSLI
#define PELAGE_SHADING_LIGHT_STRAND_HLSLI

#include "opaque_shadow.hlsli"
#include "strand_lighting.hlsli"
#include "strand_shadow.hlsli"

// World position of a fragment [m].
// \param at position in the viewport, row 0 the top row [pixels], \param depth 0..1
float3 fragmentPosition(float2 at, float depth) {
  float2 share = at / g_viewport.zw;
  float4 clip = float4(share.x * 2.0 - 1.0, 1.0 - share.y * 2.0, depth, 1.0);
  float w = dot(g_clipToWorld[3], clip);
  float3 world =
      float3(dot(g_clipToWorld[0], clip), dot(g_clipToWorld[1], clip), dot(g_clipToWorld[2], clip));
  // 0 is at infinity: reversed depth 0.
  return abs(w) > 1e-20 ? world / w : float3(0.0, 0.0, 0.0);
}

StrandSurface strandSurface(float3 position, float3 tangent, float3 baseColor) {
  return makeStrandSurface(position, tangent, g_eye.xyz, baseColor);
}

// Weight of the ray to the eye beside those of lights in ambient light: a strand that is visible is
// at the edge of the hair.
static const float kEyeRayShare = 0.35;

// Ambient light of a strand that faces the eye, where no shadow map says how deep it lies.
float3 openAmbient(StrandShading material, StrandSurface surface) {
  float3 facing = shadingNormal(surface.tangent, surface.toEye);
  float3 arriving = environmentOnFiber(surface.tangent) + (2.0 / 3.0) * environmentSlope(facing);
  return max(arriving, float3(0.0, 0.0, 0.0)) * strandAmbient(material, surface);
}

// Sums the lights of StrandViewConstants, each through the hair and past the opaque geometry in
// front of it, and ambient light. Where lights have shadow maps, these are known: what hair leaves
// of ambient light on each light's ray, and for the fiber models light that passes from fiber to
// fiber.
float3 viewLight(StrandShading material, StrandSurface surface) {
  float3 sum = float3(0.0, 0.0, 0.0);
  float3 inside = float3(0.0, 0.0, 0.0);
  float rays = 0.0;
  uint count = min(g_lightCount, kMaxStrandLights);
  for (uint i = 0u; i < count; ++i) {
    StrandLight light = lightAt(i);
    StrandIllumination arriving = strandIllumination(light, surface.position);
    float open = 1.0;
    if (light.shadow.y - 1u < kMaxStrandShadows)
      open = opaqueTransmittance(opaqueShadowAt(light.shadow.y - 1u), surface.position,
                                 arriving.toLight);
    float3 color = arriving.color * open;
    StrandLightPath path = openLightPath();
    if (light.shadow.x < kMaxStrandShadows)
      path = strandLightPath(shadowAt(light.shadow.x), surface.position);
    StrandVolume volume = strandVolumeOf(material, surface);
    if (open > 0.0)
      sum += color * shadeStrandInHair(material, surface, arriving.toLight, volume, path);
    if (path.known) {
      float facing = dot(surface.toEye, arriving.toLight);
      inside += volumeAmbient(volume, path, facing, environmentOnFiber(surface.tangent),
                              environmentSlope(arriving.toLight));
      rays += 1.0;
    }
  }
  inside *= bounded(material.body.y, 0.0, kMostStrength) / max(rays, 1.0);
  return sum + lerp(inside, openAmbient(material, surface), rays > 0.0 ? kEyeRayShare : 1.0);
}

#ifdef ENGINE_LIGHTS_SPACE
// Defined in the engine's file.
float3 engineLight(StrandShading material, StrandSurface surface);

float3 lightStrand(StrandShading material, StrandSurface surface) {
  return engineLight(material, surface);
}
#else
float3 lightStrand(StrandShading material, StrandSurface surface) {
  return viewLight(material, surface);
}
#endif

#endif
