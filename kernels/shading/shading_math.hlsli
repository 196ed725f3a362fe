// Small functions of the shading code that stay finite.
#ifndef PELAGE_SHADING_SHADING_MATH_HLSLI
#define PELAGE_SHADING_SHADING_MATH_HLSLI

static const float kShadingPi = 3.14159265359;
// Strengths over this are a mistake; the product with a light's colour stays finite.
static const float kMostStrength = 64.0;

// Like clamp(), but `low` for NaN, for which clamp() may be anything.
float bounded(float value, float low, float high) {
  float result = low;
  if (value >= low) result = min(value, high);
  return result;
}

// An albedo: what reflects more than all light, or a part of it that is not a number, does not
// exist.
float3 boundedColor(float3 color) {
  return float3(bounded(color.x, 0.0, 1.0), bounded(color.y, 0.0, 1.0),
                bounded(color.z, 0.0, 1.0));
}

// The unit vector along v, or `other` where v has no direction.
float3 unitOr(float3 v, float3 other) {
  float squared = dot(v, v);
  // Not infinite either.
  if (!(squared > 1e-20 && squared < 1e30)) return other;
  return v * (1.0 / sqrt(squared));
}

// Cosine to a sine and the other way around.
float otherLeg(float leg) { return sqrt(max(1.0 - leg * leg, 0.0)); }

// The unit vector at right angles to a fibre that is nearest to the eye.
float3 shadingNormal(float3 tangent, float3 toEye) {
  // Along the line of sight any one does.
  float3 axis = abs(tangent.y) < 0.7 ? float3(0.0, 1.0, 0.0) : float3(1.0, 0.0, 0.0);
  float3 side = unitOr(axis - tangent * dot(tangent, axis), axis);
  float3 normal = toEye - tangent * dot(tangent, toEye);
  if (!(dot(normal, normal) > 1e-8)) return side;
  return unitOr(normal, side);
}

#endif
