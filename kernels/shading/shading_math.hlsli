// Small functions for shading that return finite values.
//
// These do not return early, nor do those that find a point in a shadow map of hair and read its
// texels: NVIDIA's OpenGL compiler keeps a flag for each early return. With those in
// strand_shadow.hlsli and shadow_faces.hlsli, shade_strand_tiles took 924 us of an H200 for 344.
#ifndef PELAGE_SHADING_SHADING_MATH_HLSLI
#define PELAGE_SHADING_SHADING_MATH_HLSLI

static const float kShadingPi = 3.14159265359;
// Maximum strength; the product with a light's color stays finite.
static const float kMostStrength = 64.0;

// Like clamp(), but returns `low` for NaN, for which clamp() is undefined.
float bounded(float value, float low, float high) { return value >= low ? min(value, high) : low; }

// Clamps an albedo to 0..1; NaN becomes a valid value.
float3 boundedColor(float3 color) {
  return float3(bounded(color.x, 0.0, 1.0), bounded(color.y, 0.0, 1.0), bounded(color.z, 0.0, 1.0));
}

// Returns the unit vector along v, or `other` if v has no direction.
float3 unitOr(float3 v, float3 other) {
  float squared = dot(v, v);
  // Not infinite either.
  return squared > 1e-20 && squared < 1e30 ? v * rsqrt(squared) : other;
}

// Returns the cosine for a sine and vice versa.
float otherLeg(float leg) { return sqrt(max(1.0 - leg * leg, 0.0)); }

// Returns the unit vector at right angles to a fiber that is nearest to the eye.
float3 shadingNormal(float3 tangent, float3 toEye) {
  // Along the line of sight any vector is valid.
  float3 axis = abs(tangent.y) < 0.7 ? float3(0.0, 1.0, 0.0) : float3(1.0, 0.0, 0.0);
  float3 side = unitOr(axis - tangent * dot(tangent, axis), axis);
  float3 normal = toEye - tangent * dot(tangent, toEye);
  return unitOr(dot(normal, normal) > 1e-8 ? normal : side, side);
}

#endif
