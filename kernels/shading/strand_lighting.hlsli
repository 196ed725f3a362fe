// Light that a strand sends to the eye, for the project's kernels and for an engine's own: no
// resources. docs/shading.md has an example.
//
// Unit of light: 1 is what makes a white Lambert surface that faces the light as bright as 1
// (irradiance pi).
// Invariant (tests/kernel/fiber_shading_test): finite and not negative for every argument.
#ifndef PELAGE_SHADING_STRAND_LIGHTING_HLSLI
#define PELAGE_SHADING_STRAND_LIGHTING_HLSLI

#include "../layouts/shading.hlsli"
#include "fiber_bsdf.hlsli"
#include "kajiya_kay.hlsli"
#include "shading_math.hlsli"

struct StrandSurface {
  float3 position;   // world [m]
  float3 tangent;    // unit, from root to tip
  float3 toEye;      // unit
  float3 baseColor;  // linear rgb, 0..1
  float offset;      // from the centre line over the radius, -1..1, > 0 towards tangent x toEye
};

// A light as it arrives somewhere.
struct StrandIllumination {
  float3 toLight;  // unit
  float3 color;    // linear rgb, see StrandLight.color
};

// \param tangent, \param eye need not be unit or apart from `position`.
StrandSurface makeStrandSurface(float3 position, float3 tangent, float3 eye, float3 baseColor) {
  StrandSurface surface;
  surface.position = position;
  surface.tangent = unitOr(tangent, float3(0.0, 1.0, 0.0));
  surface.toEye = unitOr(eye - position, float3(0.0, 0.0, 1.0));
  surface.baseColor = baseColor;
  surface.offset = 0.0;
  return surface;
}

StrandIllumination strandIllumination(StrandLight light, float3 position) {
  StrandIllumination result;
  bool placed = light.direction.w > 0.5;
  float3 way = placed ? light.direction.xyz - position : light.direction.xyz;
  result.toLight = unitOr(way, float3(0.0, 1.0, 0.0));
  // Nearer than a centimetre a light without extent has no meaning.
  float fallOff = placed ? 1.0 / max(dot(way, way), 1e-4) : 1.0;
  result.color = light.color.rgb * fallOff;
  return result;
}

// Light to the eye from a directional light of 1 (above) in direction `toLight`, not shadowed.
float3 shadeStrand(StrandShading m, StrandSurface s, float3 toLight) {
  float3 tangent = unitOr(s.tangent, float3(0.0, 1.0, 0.0));
  float3 light = unitOr(toLight, tangent);
  float3 eye = unitOr(s.toEye, tangent);
  float3 base = boundedColor(s.baseColor);
  if (m.model.x == kStrandKajiyaKay) return kajiyaKay(m, tangent, eye, light, base);

  FiberModel fiber = makeFiberModel(m.fiber, base);
  FiberAngles angles = fiberAngles(tangent, eye, light);
  float3 single = m.model.x == kStrandNearFiber
                      ? nearFiberScattering(fiber, angles, bounded(s.offset, -1.0, 1.0))
                      : fiberScattering(fiber, angles);
  // Isotropic in the sense of Kajiya and Kay: f = base / pi^2 sends on `base` of what arrives.
  float share = bounded(m.body.z, 0.0, 1.0);
  float3 scattered = base * (angles.cosLight / (kShadingPi * kShadingPi));
  return kShadingPi * lerp(single, scattered, share);
}

// Light to the eye from light of 1 that comes from all sides. What hair as a whole sends on of such
// light is its base colour, by the definition that Chiang et al. 2016 give that.
float3 strandAmbient(StrandShading m, StrandSurface s) {
  return boundedColor(s.baseColor) * bounded(m.body.y, 0.0, kMostStrength);
}

#endif
