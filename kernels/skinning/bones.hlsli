// Blends up to four bones at a point. A blend is a sum to which bones are added one by one.
//
// The including file defines what its layout calls the bones:
//   BONE_TRANSFORMS  buffer of float4: 3 rows of [M | t] per bone, or 2 quaternions (below)
//   BONE_COUNT       bones in it
#ifndef PELAGE_SKINNING_BONES_HLSLI
#define PELAGE_SKINNING_BONES_HLSLI

#include "../base/quaternion.hlsli"
#include "polar_rotation.hlsli"

// Returns true if a bone takes part: it exists and its weight is a number above 0.
bool boneCounts(uint bone, float weight) {
  return bone < BONE_COUNT && isUsable(float3(weight, 0.0, 0.0)) && weight > 0.0;
}

// Returns the weights; if no bone takes part, only the first one.
float4 weightsOfBones(uint4 bones, float4 weights) {
  if (!boneCounts(bones.x, weights.x) && !boneCounts(bones.y, weights.y) &&
      !boneCounts(bones.z, weights.z) && !boneCounts(bones.w, weights.w))
    return float4(1.0, 0.0, 0.0, 0.0);
  return weights;
}

// ---- matrices

// Rows of [M | t].
struct BoneMatrix {
  float4 a;
  float4 b;
  float4 c;
};

struct MatrixBlend {
  BoneMatrix sum;        // weighted
  BoneMatrix strongest;  // the bone of the largest weight, the first one of equals
  float strongestWeight;
  float weightSum;
  float volume;  // weighted sum of |det M|
  bool usable;   // false once a bone had a NaN, an infinity or a number above 1e18
};

MatrixBlend emptyMatrixBlend() {
  MatrixBlend blend;
  blend.sum.a = float4(0.0, 0.0, 0.0, 0.0);
  blend.sum.b = float4(0.0, 0.0, 0.0, 0.0);
  blend.sum.c = float4(0.0, 0.0, 0.0, 0.0);
  blend.strongest = blend.sum;
  blend.strongestWeight = 0.0;
  blend.weightSum = 0.0;
  blend.volume = 0.0;
  blend.usable = true;
  return blend;
}

MatrixBlend addMatrixBone(MatrixBlend blend, uint bone, float weight) {
  if (!boneCounts(bone, weight)) return blend;
  BoneMatrix m;
  m.a = BONE_TRANSFORMS[bone * 3];
  m.b = BONE_TRANSFORMS[bone * 3 + 1];
  m.c = BONE_TRANSFORMS[bone * 3 + 2];
  blend.usable = blend.usable && isUsable(m.a) && isUsable(m.b) && isUsable(m.c);
  precise float weightSum = blend.weightSum + weight;
  precise float volume = blend.volume + abs(determinant3(m.a.xyz, m.b.xyz, m.c.xyz)) * weight;
  precise float4 a = blend.sum.a + m.a * weight;
  precise float4 b = blend.sum.b + m.b * weight;
  precise float4 c = blend.sum.c + m.c * weight;
  blend.weightSum = weightSum;
  blend.volume = volume;
  blend.sum.a = a;
  blend.sum.b = b;
  blend.sum.c = c;
  if (weight > blend.strongestWeight) {
    blend.strongestWeight = weight;
    blend.strongest = m;
  }
  return blend;
}

// Divides the sums by the weights.
MatrixBlend normalizeBlend(MatrixBlend blend) {
  precise float share = 1.0 / blend.weightSum;
  precise float volume = blend.volume * share;
  precise float4 a = blend.sum.a * share;
  precise float4 b = blend.sum.b * share;
  precise float4 c = blend.sum.c * share;
  blend.volume = volume;
  blend.sum.a = a;
  blend.sum.b = b;
  blend.sum.c = c;
  return blend;
}

// Computes the blend of up to four bones, divided by the weights. Returns false if there is none,
// or if it is not finite.
bool blendMatrices(uint4 bones, float4 weights, out MatrixBlend blend) {
  blend = emptyMatrixBlend();
  blend = addMatrixBone(blend, bones.x, weights.x);
  blend = addMatrixBone(blend, bones.y, weights.y);
  blend = addMatrixBone(blend, bones.z, weights.z);
  blend = addMatrixBone(blend, bones.w, weights.w);
  if (!(blend.weightSum > 0.0) || !blend.usable) return false;
  blend = normalizeBlend(blend);
  return true;
}

// Returns a bind position moved by the blend.
float3 moveByBlend(MatrixBlend blend, float3 bind) {
  precise float x = dot3(blend.sum.a.xyz, bind) + blend.sum.a.w;
  precise float y = dot3(blend.sum.b.xyz, bind) + blend.sum.b.w;
  precise float z = dot3(blend.sum.c.xyz, bind) + blend.sum.c.w;
  return float3(x, y, z);
}

// Returns the rotation of a blend. A blend that has lost more than three quarters of its bones'
// volume has no meaningful rotation, and the strongest bone decides: two bones of equal weight are
// then 120 degrees apart (volume cos^2 of half the angle), or one of them is mirrored.
float4 rotationOfBlend(MatrixBlend blend, float4 fallback) {
  precise float det = determinant3(blend.sum.a.xyz, blend.sum.b.xyz, blend.sum.c.xyz);
  precise float leastVolume = 0.25 * blend.volume;
  BoneMatrix m = blend.sum;
  if (!(abs(det) >= leastVolume)) m = blend.strongest;
  return rotationOfMatrix(m.a.xyz, m.b.xyz, m.c.xyz, fallback);
}

// ---- dual quaternions
// Bone: BONE_TRANSFORMS[2 b] real part r, [2 b + 1] dual part d = t r / 2 for the rigid motion
// p -> rotate(r, p) + t, with t as the quaternion (t, 0).

struct DualBlend {
  float4 real;  // weighted sums
  float4 dual;
  bool usable;  // false once a bone had a NaN, an infinity, a number above 1e18 or no rotation
};

// Dual quaternion linear blending (Kavan, Collins, Zara and O'Sullivan, "Geometric Skinning with
// Approximate Dual Quaternion Blending", ACM Trans. Graph. 27(4), 2008, section 3.2), with the
// antipodality fix of its section 4.1: a bone whose real part points away from the pivot's is
// negated. The pivot is the real part of the bone of the largest weight.
DualBlend addDualBone(DualBlend blend, uint bone, float weight, float4 pivot) {
  if (!boneCounts(bone, weight)) return blend;
  float4 real = BONE_TRANSFORMS[bone * 2];
  float4 dual = BONE_TRANSFORMS[bone * 2 + 1];
  precise float squared = dot4(real, real);
  blend.usable = blend.usable && isUsable(real) && isUsable(dual) && squared > 1e-12;
  precise float share = weight * inverseRoot(max(squared, 1e-12));
  if (dot4(real, pivot) < 0.0) share = -share;
  precise float4 sumReal = blend.real + real * share;
  precise float4 sumDual = blend.dual + dual * share;
  blend.real = sumReal;
  blend.dual = sumDual;
  return blend;
}

struct RigidMotion {
  float4 rotation;     // unit quaternion
  float3 translation;  // after the rotation [m]
};

// Computes the blend of up to four bones as a rigid motion. Returns false if there is none, or if
// it is not finite.
bool blendDualQuaternions(uint4 bones, float4 weights, out RigidMotion motion) {
  motion.rotation = float4(0.0, 0.0, 0.0, 1.0);
  motion.translation = float3(0.0, 0.0, 0.0);
  uint strongest = bones.x;
  float strongestWeight = 0.0;
  if (boneCounts(bones.x, weights.x)) strongestWeight = weights.x;
  if (boneCounts(bones.y, weights.y) && weights.y > strongestWeight) {
    strongest = bones.y;
    strongestWeight = weights.y;
  }
  if (boneCounts(bones.z, weights.z) && weights.z > strongestWeight) {
    strongest = bones.z;
    strongestWeight = weights.z;
  }
  if (boneCounts(bones.w, weights.w) && weights.w > strongestWeight) {
    strongest = bones.w;
    strongestWeight = weights.w;
  }
  if (!(strongestWeight > 0.0)) return false;
  float4 pivot = BONE_TRANSFORMS[strongest * 2];
  DualBlend blend;
  blend.real = float4(0.0, 0.0, 0.0, 0.0);
  blend.dual = float4(0.0, 0.0, 0.0, 0.0);
  blend.usable = true;
  blend = addDualBone(blend, bones.x, weights.x, pivot);
  blend = addDualBone(blend, bones.y, weights.y, pivot);
  blend = addDualBone(blend, bones.z, weights.z, pivot);
  blend = addDualBone(blend, bones.w, weights.w, pivot);
  if (!blend.usable) return false;
  // No bone points away from the pivot, so the sum is at least as long as its own weight.
  float inverse = inverseRoot(max(dot4(blend.real, blend.real), 1e-24));
  precise float4 real = blend.real * inverse;
  precise float4 dual = blend.dual * inverse;
  float4 moved = multiplyQuaternions(dual, conjugate(real));
  precise float3 translation = moved.xyz * 2.0;
  motion.rotation = normalizeQuaternion(real);
  motion.translation = translation;
  return true;
}

// Returns a bind position moved by the motion.
float3 moveRigidly(RigidMotion motion, float3 bind) {
  precise float3 position = rotate(motion.rotation, bind) + motion.translation;
  return position;
}

#endif
