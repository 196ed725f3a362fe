// Light that a strand sends to the eye, for the project's kernels and for an engine's own: no
// resources. docs/shading.md has an example.
//
// Unit of light: a light of 1 makes a white Lambert surface that faces it as bright as 1
// (irradiance pi).
// Invariant (tests/shading/fiber_shading_test): finite and not negative for every argument.
#ifndef PELAGE_SHADING_STRAND_LIGHTING_HLSLI
#define PELAGE_SHADING_STRAND_LIGHTING_HLSLI

#include "layouts/shading.hlsli"
#include "fiber_bsdf.hlsli"
#include "kajiya_kay.hlsli"
#include "shading_math.hlsli"
#include "strand_volume.hlsli"

struct StrandSurface {
  float3 position;   // world [m]
  float3 tangent;    // unit, from root to tip
  float3 toEye;      // unit
  float3 baseColor;  // linear rgb, 0..1
  float2 uv;         // of the root, 0..1; 0 where it is not known
  float offset;      // from the center line over the radius, -1..1, > 0 towards tangent x toEye
};

// A light as it arrives at a point.
struct StrandIllumination {
  float3 toLight;  // unit
  float3 color;    // linear rgb, see StrandLight.color
};

// \param tangent need not be unit; \param eye may be equal to `position`.
StrandSurface makeStrandSurface(float3 position, float3 tangent, float3 eye, float3 baseColor) {
  StrandSurface surface;
  surface.position = position;
  surface.tangent = unitOr(tangent, float3(0.0, 1.0, 0.0));
  surface.toEye = unitOr(eye - position, float3(0.0, 0.0, 1.0));
  surface.baseColor = baseColor;
  surface.uv = float2(0.0, 0.0);
  surface.offset = 0.0;
  return surface;
}

StrandIllumination strandIllumination(StrandLight light, float3 position) {
  StrandIllumination result;
  bool positional = light.direction.w > 0.5;
  float3 lightOffset = positional ? light.direction.xyz - position : light.direction.xyz;
  result.toLight = unitOr(lightOffset, float3(0.0, 1.0, 0.0));
  // A light without extent has no meaning nearer than a centimeter.
  float fallOff = positional ? 1.0 / max(dot(lightOffset, lightOffset), 1e-4) : 1.0;
  if (positional && dot(light.cone.xyz, light.cone.xyz) > 0.0) {
    float share = saturate(dot(light.cone.xyz, result.toLight) + light.cone.w);
    fallOff *= share * share;
  }
  result.color = light.color.rgb * fallOff;
  return result;
}

// Returns the light to the eye from a directional light of 1 (above) in direction `toLight`, not
// shadowed.
float3 shadeStrand(StrandShading m, StrandSurface s, float3 toLight) {
  float3 tangent = unitOr(s.tangent, float3(0.0, 1.0, 0.0));
  float3 light = unitOr(toLight, tangent);
  float3 eye = unitOr(s.toEye, tangent);
  float3 base = boundedColor(s.baseColor);
  if (m.model.x == kStrandKajiyaKay) return kajiyaKay(m, tangent, eye, light, base);

  FiberModel fiber = makeFiberModel(m.fiber, base);
  FiberAngles angles = fiberAngles(tangent, eye, light);
  float4 lobes = longitudinalLobes(fiber, angles);
  float3 single = m.model.x == kStrandNearFiber
                      ? nearFiberScattering(fiber, angles, lobes, bounded(s.offset, -1.0, 1.0))
                      : fiberScattering(fiber, angles, lobes);
  // Isotropic in the sense of Kajiya and Kay: f = base / pi^2 reflects `base` of the incoming
  // light.
  float share = bounded(m.body.z, 0.0, 1.0);
  float3 scattered = base * (angles.cosLight / (kShadingPi * kShadingPi));
  return kShadingPi * lerp(single, scattered, share);
}

StrandVolume strandVolumeOf(StrandShading m, StrandSurface s) {
  return strandVolume(makeFiberModel(m.fiber, boundedColor(s.baseColor)));
}

// Returns the same through hair. The fiber models have the light that passes from fiber to fiber,
// by the share m.body.w. \param volume strandVolumeOf() the surface
float3 shadeStrandInHair(StrandShading m, StrandSurface s, float3 toLight, StrandVolume volume,
                         StrandLightPath path) {
  float share = m.model.x == kStrandKajiyaKay ? 0.0 : bounded(m.body.w, 0.0, 1.0);
  float3 dimmed = float3(1.0, 1.0, 1.0) * path.transmittance;
  float3 light = shadeStrand(m, s, toLight);
  if (!(share > 0.0)) return light * dimmed;
  return light * lerp(dimmed, volumeBeam(volume, path), share) +
         share * volumeDiffuse(volume, path);
}

// Returns the light to the eye from light of 1 from all sides. Hair as a whole reflects its base
// color of such light, by the definition of Chiang et al. 2016.
float3 strandAmbient(StrandShading m, StrandSurface s) {
  return boundedColor(s.baseColor) * bounded(m.body.y, 0.0, kMostStrength);
}

#endif
