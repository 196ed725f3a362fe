// Converts the bones that an engine has in a buffer of its own to those that skinning reads.
//
// Threads: one per bone, in rows of 2^20.
// Reads:   g_engineBones
// Writes:  g_convertedBones
// Run it once for each skeleton and form, in frames in which the engine has written bones.
//
// Matrices become dual quaternions by the rotation nearest to them, and dual quaternions matrices.
//
// Invariant (tests/skinning): where the form stays and the origin is whole meters, matrices have
// the bits that the host would upload, and with the origin at 0 dual quaternions have their own. A
// bone with a NaN, an infinity, a number above 1e18 or, as a dual quaternion, no rotation becomes
// one that skinning does not use: roots and vertices that it moves stay where they were.
#include "layouts/bone_conversion.hlsli"
#include "polar_rotation.hlsli"
#include "../base/dispatch.hlsli"

struct Bone {
  float4 a;  // rows of [M | t]
  float4 b;
  float4 c;
  float4 real;  // dual quaternion
  float4 dual;
  bool usable;
};

float4 engineFloats(uint first, uint step) {
  return float4(g_engineBones[first], g_engineBones[first + step], g_engineBones[first + 2u * step],
                g_engineBones[first + 3u * step]);
}

float3 relativeToOrigin(float3 p) {
  precise float3 r = (p - g_boneOrigin.xyz) - g_boneOriginRest.xyz;
  return r;
}

float4 dualOfTranslation(float3 translation, float4 real) {
  precise float3 halved = translation * 0.5;
  return multiplyQuaternions(float4(halved, 0.0), real);
}

Bone boneOfMatrix(uint first) {
  bool columns = g_engineBoneLayout == kBoneColumns;
  uint row = columns ? 1u : 4u;
  uint column = columns ? 4u : 1u;
  Bone bone;
  bone.a = engineFloats(first, column);
  bone.b = engineFloats(first + row, column);
  bone.c = engineFloats(first + 2u * row, column);
  float3 translation = relativeToOrigin(float3(bone.a.w, bone.b.w, bone.c.w));
  bone.a.w = translation.x;
  bone.b.w = translation.y;
  bone.c.w = translation.z;
  bone.usable = isUsable(bone.a) && isUsable(bone.b) && isUsable(bone.c);
  bone.real = float4(0.0, 0.0, 0.0, 1.0);
  bone.dual = float4(0.0, 0.0, 0.0, 0.0);
  if (g_convertToDual == 0u || !bone.usable) return bone;
  bone.real = rotationOfMatrix(bone.a.xyz, bone.b.xyz, bone.c.xyz, bone.real);
  bone.dual = dualOfTranslation(translation, bone.real);
  return bone;
}

Bone boneOfDualQuaternion(uint first) {
  Bone bone;
  bone.real = engineFloats(first, 1u);
  bone.dual = engineFloats(first + 4u, 1u);
  precise float squared = dot4(bone.real, bone.real);
  bone.usable = isUsable(bone.real) && isUsable(bone.dual) && squared > 1e-12;
  if (g_convertToDual != 0u) {
    precise float3 origin = g_boneOrigin.xyz + g_boneOriginRest.xyz;
    precise float4 dual = bone.dual - dualOfTranslation(origin, bone.real);
    bone.dual = dual;
  }
  float inverse = inverseRoot(max(squared, 1e-12));
  precise float4 q = bone.real * inverse;
  precise float4 d = bone.dual * inverse;
  float4 moved = multiplyQuaternions(d, conjugate(q));
  precise float3 world = moved.xyz * 2.0;
  float3 translation = relativeToOrigin(world);
  float3 x = rotate(q, float3(1.0, 0.0, 0.0));
  float3 y = rotate(q, float3(0.0, 1.0, 0.0));
  float3 z = rotate(q, float3(0.0, 0.0, 1.0));
  bone.a = float4(x.x, y.x, z.x, translation.x);
  bone.b = float4(x.y, y.y, z.y, translation.y);
  bone.c = float4(x.z, y.z, z.z, translation.z);
  return bone;
}

[numthreads(64, 1, 1)]
void convert_bones(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_convertedCount) return;

  uint first = g_engineBoneOffset + g_engineBoneStride * index;
  Bone bone;
  if (g_engineBoneLayout == kBoneDualQuaternions)
    bone = boneOfDualQuaternion(first);
  else
    bone = boneOfMatrix(first);
  if (!bone.usable) {
    bone.a = unusableRow();
    bone.b = unusableRow();
    bone.c = unusableRow();
    bone.real = unusableRow();
    bone.dual = unusableRow();
  }
  if (g_convertToDual != 0u) {
    g_convertedBones[index * 2] = bone.real;
    g_convertedBones[index * 2 + 1] = bone.dual;
  } else {
    g_convertedBones[index * 3] = bone.a;
    g_convertedBones[index * 3 + 1] = bone.b;
    g_convertedBones[index * 3 + 2] = bone.c;
  }
}
