// Quaternions of the baselines, with the built-in functions and as fast as a driver makes them:
// their bits are compared with nothing. xyz vector part, w scalar part; a * b rotates by b first.
#ifndef BASELINE_ROTATIONS_HLSLI
#define BASELINE_ROTATIONS_HLSLI

float4 conjugate(float4 q) { return float4(-q.xyz, q.w); }

float4 product(float4 a, float4 b) {
  return float4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

float3 rotate(float4 q, float3 v) {
  float3 twice = 2.0 * cross(q.xyz, v);
  return v + q.w * twice + cross(q.xyz, twice);
}

// The rotated x axis.
float3 axisX(float4 q) {
  return float3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z),
                2.0 * (q.x * q.z - q.w * q.y));
}

// The shortest rotation between unit vectors; about any axis where they are opposite.
float4 rotationBetween(float3 a, float3 b) {
  float scalar = 1.0 + dot(a, b);
  if (scalar < 1e-6) {
    float3 axis = abs(a.x) > abs(a.z) ? float3(-a.y, a.x, 0.0) : float3(0.0, -a.z, a.y);
    return float4(normalize(axis), 0.0);
  }
  return normalize(float4(cross(a, b), scalar));
}

// On the shorter arc.
float4 blendRotations(float4 a, float4 b, float t) {
  float side = dot(a, b) < 0.0 ? -1.0 : 1.0;
  return normalize(lerp(a, b * side, t));
}

#endif
