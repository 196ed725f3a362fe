// Vectors and quaternions for kernels that decide state: every operation is `precise`, in an order
// that is written out, so that one driver gives the same bits on every API. The built-in dot() and
// cross() leave order and contraction to the driver.
//
// A quaternion is a float4, xyz vector part and w scalar part; a product a * b rotates by b first.
#ifndef PELAGE_BASE_QUATERNION_HLSLI
#define PELAGE_BASE_QUATERNION_HLSLI

#include "roots.hlsli"

float dot3(float3 a, float3 b) {
  precise float r = a.x * b.x + a.y * b.y + a.z * b.z;
  return r;
}

float dot4(float4 a, float4 b) {
  precise float r = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
  return r;
}

float3 cross3(float3 a, float3 b) {
  precise float3 r = float3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return r;
}

// The bits of 1e18.
static const uint kUsableBits = 0x5d5e0b6bu;

// Returns true if every component is a number of magnitude below 1e18: its square and the squares
// of distances are finite then. On the bits, because a driver may assume that no float is a NaN.
bool isUsable(float3 v) {
  uint3 bits = asuint(v) & 0x7fffffffu;
  return max(bits.x, max(bits.y, bits.z)) < kUsableBits;
}

bool isUsable(float4 v) {
  uint4 bits = asuint(v) & 0x7fffffffu;
  return max(max(bits.x, bits.w), max(bits.y, bits.z)) < kUsableBits;
}

// Returns false for a pose that was never written, and for numbers that cannot be a pose.
bool isPose(float4 rotation, float3 position) {
  if (!isUsable(rotation) || !isUsable(position)) return false;
  precise float squared = dot4(rotation, rotation);
  return squared > 0.25 && squared < 4.0;
}

// v / |v|, or the fallback where |v| is below 1e-12, above 1e19 or not a number.
float3 directionOr(float3 v, float3 fallback) {
  precise float squared = dot3(v, v);
  // Positive floats order like their bits: 1e-24 < squared < 1e38; a NaN is above.
  uint bits = asuint(squared);
  bool usable = bits > 0x179abe15u && bits < 0x7e967699u;
  float inverse = inverseRoot(squared);
  precise float3 r = v * inverse;
  float3 result = usable ? r : fallback;
  return result;
}

// A unit vector at right angles to a unit vector.
float3 perpendicular(float3 v) {
  precise float flat = abs(v.x) + abs(v.y);
  return flat < 0.1 ? directionOr(float3(0.0, -v.z, v.y), float3(1.0, 0.0, 0.0))
                    : directionOr(float3(-v.y, v.x, 0.0), float3(1.0, 0.0, 0.0));
}

float4 conjugate(float4 q) { return float4(-q.x, -q.y, -q.z, q.w); }

// Unit quaternion; identity where |q| is below 1e-12, above 1e19 or not a number.
float4 normalizeQuaternion(float4 q) {
  precise float squared = dot4(q, q);
  uint bits = asuint(squared);
  bool usable = bits > 0x179abe15u && bits < 0x7e967699u;
  float inverse = inverseRoot(squared);
  precise float4 r = q * inverse;
  float4 identity = float4(0.0, 0.0, 0.0, 1.0);
  float4 result = usable ? r : identity;
  return result;
}

float4 multiplyQuaternions(float4 a, float4 b) {
  precise float4 r = float4(a.w * b.x + a.x * b.w + (a.y * b.z - a.z * b.y),
                            a.w * b.y + a.y * b.w + (a.z * b.x - a.x * b.z),
                            a.w * b.z + a.z * b.w + (a.x * b.y - a.y * b.x),
                            a.w * b.w - (a.x * b.x + a.y * b.y + a.z * b.z));
  return r;
}

// Returns rotate(q, v) - v, for a unit quaternion: exactly 0 for the identity, so that a point
// without rotation does not move.
float3 rotationDelta(float4 q, float3 v) {
  precise float3 twice = cross3(q.xyz, v) * 2.0;
  precise float3 r = twice * q.w + cross3(q.xyz, twice);
  return r;
}

// Returns v rotated by a unit quaternion.
float3 rotate(float4 q, float3 v) {
  precise float3 r = v + rotationDelta(q, v);
  return r;
}

// Returns the shortest rotation from unit vector a to unit vector b, by the half-angle vector,
// without trigonometry. Opposite vectors rotate about an arbitrary axis at right angles.
float4 rotationBetween(float3 a, float3 b) {
  precise float scalar = 1.0 + dot3(a, b);
  // Below 1e-5 (0.26 degrees from opposite) the sum above has lost its digits.
  if (scalar < 1e-5) return float4(perpendicular(a), 0.0);
  precise float3 axis = cross3(a, b);
  return normalizeQuaternion(float4(axis, scalar));
}

// Normalized linear interpolation on the shorter arc; exactly a at t = 0 and b at t = 1.
float4 interpolateQuaternions(float4 a, float4 b, float t) {
  if (t <= 0.0) return a;
  if (t >= 1.0) return b;
  float side = dot4(a, b) < 0.0 ? -1.0 : 1.0;
  precise float4 mixed = a + (b * side - a) * t;
  return normalizeQuaternion(mixed);
}

#endif
