// Mathematics of the exact solver beyond base/quaternion.hlsli. Everything is `precise` and in
// the order of tests/reference/rod, whose float results these kernels reproduce bit by bit where
// the device's square root and division are exact.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_MATH_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_MATH_HLSLI

#include "../../base/quaternion.hlsli"

// Minimum twist stiffness, and minimum pivot, over the trace of the system: in exact arithmetic a
// sub-chain has no stiffness against twist but its own; what float computes there is rounding of
// either sign. Found by halving until strands of the fuzz test broke; ten times larger is visible.
static const float kTwistFloor = 2e-6;
static const float kPivotFloor = 2e-7;
static const float kTiny = 1e-22;

// Maximum rotation of an edge by its rate in the guess, and by a Newton step [rad].
static const float kGuessLimit = 0.5;
static const float kStepLimit = 1.0;

struct Symmetric3 {
  float xx;
  float xy;
  float xz;
  float yy;
  float yz;
  float zz;
};

// `precise` reaches the arithmetic of a struct's members only through scalars, so every function
// here computes scalars and puts them together.
Symmetric3 makeSymmetric(float xx, float xy, float xz, float yy, float yz, float zz) {
  Symmetric3 a;
  a.xx = xx;
  a.xy = xy;
  a.xz = xz;
  a.yy = yy;
  a.yz = yz;
  a.zz = zz;
  return a;
}

Symmetric3 zeroSymmetric() { return makeSymmetric(0.0, 0.0, 0.0, 0.0, 0.0, 0.0); }

float3 multiplySymmetric(Symmetric3 a, float3 v) {
  precise float3 r =
      float3(a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
             a.xz * v.x + a.yz * v.y + a.zz * v.z);
  return r;
}

// a + au u^T, for au a multiple of u.
Symmetric3 addOuter(Symmetric3 a, float3 au, float3 u) {
  precise float xx = a.xx + au.x * u.x;
  precise float xy = a.xy + au.x * u.y;
  precise float xz = a.xz + au.x * u.z;
  precise float yy = a.yy + au.y * u.y;
  precise float yz = a.yz + au.y * u.z;
  precise float zz = a.zz + au.z * u.z;
  return makeSymmetric(xx, xy, xz, yy, yz, zz);
}

Symmetric3 addDiagonal(Symmetric3 a, float value) {
  precise float xx = a.xx + value;
  precise float yy = a.yy + value;
  precise float zz = a.zz + value;
  return makeSymmetric(xx, a.xy, a.xz, yy, a.yz, zz);
}

Symmetric3 addSymmetric(Symmetric3 a, Symmetric3 b) {
  precise float xx = a.xx + b.xx;
  precise float xy = a.xy + b.xy;
  precise float xz = a.xz + b.xz;
  precise float yy = a.yy + b.yy;
  precise float yz = a.yz + b.yz;
  precise float zz = a.zz + b.zz;
  return makeSymmetric(xx, xy, xz, yy, yz, zz);
}

Symmetric3 scaleSymmetric(Symmetric3 a, float factor) {
  precise float xx = a.xx * factor;
  precise float xy = a.xy * factor;
  precise float xz = a.xz * factor;
  precise float yy = a.yy * factor;
  precise float yz = a.yz * factor;
  precise float zz = a.zz * factor;
  return makeSymmetric(xx, xy, xz, yy, yz, zz);
}

float traceOf(Symmetric3 a) {
  precise float r = a.xx + a.yy + a.zz;
  return r;
}

// Inverse of a symmetric positive definite matrix by L D L^T with pivots of at least `floor`.
Symmetric3 inverseOf(Symmetric3 a, float least) {
  precise float i0 = 1.0 / max(a.xx, least);
  precise float l10 = a.xy * i0;
  precise float l20 = a.xz * i0;
  precise float d1 = a.yy - l10 * a.xy;
  precise float i1 = 1.0 / max(d1, least);
  precise float a21 = a.yz - l20 * a.xy;
  precise float l21 = a21 * i1;
  precise float d2 = a.zz - l20 * a.xz - l21 * a21;
  precise float i2 = 1.0 / max(d2, least);
  precise float k20 = l10 * l21 - l20;
  precise float zz = i2;
  precise float yz = -(l21 * i2);
  precise float xz = k20 * i2;
  precise float yy = i1 - l21 * yz;
  precise float xy = -(l10 * i1) - l21 * xz;
  precise float xx = i0 + l10 * l10 * i1 + k20 * xz;
  return makeSymmetric(xx, xy, xz, yy, yz, zz);
}

// For a quaternion that is known not to be near zero: a product of unit quaternions, or (v, 1).
float4 normalizeProduct(float4 q) {
  float inverse = inverseRoot(dot4(q, q));
  precise float4 r = q * inverse;
  return r;
}

// For a product of quaternions that are unit to rounding: one step of Newton from 1.
float4 polishProduct(float4 q) {
  precise float factor = 1.5 - 0.5 * dot4(q, q);
  precise float4 r = q * factor;
  return r;
}

// 1 / sqrt(squared) to rounding for squared in 1..1.25, and exactly 1 for 1: a polynomial within
// 7e-6 and one step of Newton.
float inverseRootNearOne(float squared) {
  precise float e = squared - 1.0;
  precise float y = 1.0 + e * (e * (0.36183913 - e * 0.21267281) - 0.49948119);
  precise float missing = 1.0 - (squared * y) * y;
  y = y + (y * 0.5) * missing;
  return y;
}

// For a product of a unit quaternion and (v, 1) with |v| <= 1/2.
float4 normalizeRotated(float4 q) {
  float inverse = inverseRootNearOne(dot4(q, q));
  precise float4 r = q * inverse;
  return r;
}

// Returns true if q is a unit quaternion up to its rounding, and no NaN: tests the bits of its
// square, 0.25..4.
bool isUnit(float4 q) {
  precise float squared = dot4(q, q);
  return asuint(squared) - 0x3e800000u < 0x02000000u;
}

// Unit tangent of an edge: its frame's x axis.
float3 axisX(float4 q) {
  precise float3 r = float3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z),
                            2.0 * (q.x * q.z - q.w * q.y));
  return r;
}

// Returns the frame q rotated by the rotation vector p, |p| <= 1, to second order, without
// trigonometry: the Cayley map.
float4 rotatedBy(float3 p, float4 q) {
  precise float3 halfRotation = p * 0.5;
  return normalizeRotated(multiplyQuaternions(float4(halfRotation, 1.0), q));
}

// Rotation vector of q conj(base), for small angles.
float3 rotationBetween(float4 q, float4 base) {
  float4 d = multiplyQuaternions(q, conjugate(base));
  precise float3 r = d.xyz * (d.w < 0.0 ? -2.0 : 2.0);
  return r;
}

// The upper 21 bits of a float, rounded.
float shortened(float x) { return asfloat((asuint(x) + 0x400u) & 0xfffff800u); }

static const float kHalfRotationLimit = 0.5 * kGuessLimit;

float3 limitedHalfRotation(float3 v) {
  precise float3 rotation = v;
  precise float squared = dot3(rotation, rotation);
  if (squared > kHalfRotationLimit * kHalfRotationLimit) {
    precise float factor = kHalfRotationLimit * inverseRoot(squared);
    rotation = rotation * factor;
  }
  return rotation;
}

// Returns half of the rotation vector by which an edge is predicted to rotate next, in its own
// axes, packed. The edge has rotated from `before` to `frame`, and `guessed` was the guess. Its
// bending is predicted by this rotation and `trend` times the error of the guess, its twist by the
// rotation, or less for edges slower than `slowRotation` [rad per step].
float nextHalfRotation(float4 frame, float4 before, float3 guessed, float trend,
                       float slowRotation) {
  float4 d = multiplyQuaternions(conjugate(before), frame);
  precise float3 rotation = d.xyz * (d.w < 0.0 ? -1.0 : 1.0);
  precise float slow = 0.25 * slowRotation * slowRotation;
  precise float squared = dot3(rotation, rotation);
  precise float keep = squared / max(squared + slow, kTiny);
  precise float x = rotation.x * keep;
  precise float y = rotation.y + (rotation.y - guessed.y) * trend;
  precise float z = rotation.z + (rotation.z - guessed.z) * trend;
  float3 limited = limitedHalfRotation(float3(x, y, z));
  // Three numbers of 9 bits with one exponent of 4, which is neither 0 nor 15: so the bits are
  // those of no NaN and of no denormal.
  float largest = max(max(abs(limited.x), abs(limited.y)), abs(limited.z));
  uint binade = asuint(largest) >> 23;
  uint exponent = min(max(binade, 112u) - 111u, 14u);
  precise float steps = asfloat((150u - exponent) << 23);  // 2^(23 - exponent)
  precise float3 rounded = floor(limited * steps + 0.5) + 256.0;
  uint3 code = uint3(clamp(rounded, 0.0, 511.0));
  return asfloat((exponent << 27) | (code.x << 18) | (code.y << 9) | code.z);
}

// Returns the prediction of g_state, scaled by `ratio`; shortened. After a reset there is none.
float3 halfRotationOn(float stored, float ratio) {
  uint bits = asuint(stored);
  uint3 code = uint3((bits >> 18) & 511u, (bits >> 9) & 511u, bits & 511u);
  precise float unit = asfloat((((bits >> 27) & 15u) + 104u) << 23);  // 2^(exponent - 23)
  unit = bits == 0u ? 0.0 : unit;
  precise float3 next = (float3(code) - 256.0) * unit;
  precise float3 further = next * ratio;
  float3 rotation = limitedHalfRotation(further);
  return float3(shortened(rotation.x), shortened(rotation.y), shortened(rotation.z));
}

// Returns the frame rotated in its own axes.
float4 guessFrame(float4 frame, float3 halfRotation) {
  return normalizeRotated(multiplyQuaternions(frame, float4(halfRotation, 1.0)));
}

// Returns a joint's rotation at rest, which has no component about the previous edge: y, z and w of
// a quaternion with w >= 0, from y / (1 + w) and z / (1 + w).
float3 restRotation(float2 stored) {
  precise float factor = 2.0 / (1.0 + (stored.x * stored.x + stored.y * stored.y));
  precise float2 yz = stored * factor;
  precise float w = factor - 1.0;
  return float3(yz, w);
}

// a conj(rest).
float4 withoutRest(float4 a, float3 rest) {
  precise float4 r = float4(
      a.x * rest.z - a.y * rest.y + a.z * rest.x, a.y * rest.z - a.w * rest.x + a.x * rest.y,
      a.z * rest.z - a.w * rest.y - a.x * rest.x, a.w * rest.z + a.y * rest.x + a.z * rest.y);
  return r;
}

#endif
