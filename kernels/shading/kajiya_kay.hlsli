// Kajiya-Kay: diffuse light and two shifted highlights. Fast, but it does not conserve energy
// (docs/shading.md).
#ifndef PELAGE_SHADING_KAJIYA_KAY_HLSLI
#define PELAGE_SHADING_KAJIYA_KAY_HLSLI

#include "layouts/shading.hlsli"
#include "shading_math.hlsli"

// Diffuse light on a fiber: the sine of the angle between tangent and light (Kajiya and Kay,
// "Rendering fur with three dimensional textures", SIGGRAPH 1989, equation 14).
float fiberDiffuse(float3 tangent, float3 toLight) { return otherLeg(dot(tangent, toLight)); }

// Highlight of a fiber (Kajiya and Kay 1989, equation 16, with the half vector and the shifted
// tangents of Scheuermann, "Practical real-time hair rendering and shading", SIGGRAPH sketch 2004).
// \param normal unit vector at right angles to the tangent; \param shift > 0 tilts towards it.
float fiberSpecular(float3 tangent, float3 normal, float3 toLight, float3 toEye, float shift,
                    float exponent) {
  float3 tilted = normalize(tangent + normal * shift);
  float3 middle = toLight + toEye;
  float length2 = dot(middle, middle);
  if (!(length2 > 1e-12)) return 0.0;
  float cosine = dot(tilted, middle) / sqrt(length2);
  float sine = otherLeg(cosine);
  // Fades where the light comes from behind the tilted fiber.
  float front = smoothstep(-1.0, 0.0, cosine);
  // pow() of 0 is not defined everywhere.
  return front * pow(max(sine, 1e-6), max(exponent, 1.0));
}

// One highlight. \param lobe strength, exponent, shift, share of the base color.
// The shift tilts the normal along the fiber: negative towards the root, the side of the primary
// highlight's light, as the scales of the cuticle do (Marschner et al., "Light scattering from
// human hair fibers", SIGGRAPH 2003, section 5.2 and table 1).
float3 kajiyaKayHighlight(float4 lobe, float3 tangent, float3 normal, float3 toLight, float3 toEye,
                          float3 base) {
  float shift = bounded(lobe.z, -1.0, 1.0);
  float exponent = bounded(lobe.y, 1.0, 10000.0);
  float light = bounded(lobe.x, 0.0, kMostStrength) *
                fiberSpecular(tangent, normal, toLight, toEye, -shift, exponent);
  return light * lerp(float3(1.0, 1.0, 1.0), base, bounded(lobe.w, 0.0, 1.0));
}

// \param tangent, \param toEye, \param toLight unit vectors; \param base 0..1.
float3 kajiyaKay(StrandShading m, float3 tangent, float3 toEye, float3 toLight, float3 base) {
  float3 normal = shadingNormal(tangent, toEye);
  float diffuse = bounded(m.body.x, 0.0, kMostStrength) * fiberDiffuse(tangent, toLight);
  return base * diffuse + kajiyaKayHighlight(m.primary, tangent, normal, toLight, toEye, base) +
         kajiyaKayHighlight(m.secondary, tangent, normal, toLight, toEye, base);
}

#endif
