// Resources of the conversion of an engine's bones. Group "boneConversion", all in space0.
#ifndef PELAGE_SKINNING_LAYOUTS_BONE_CONVERSION_HLSLI
#define PELAGE_SKINNING_LAYOUTS_BONE_CONVERSION_HLSLI

// How g_engineBones holds a bone.
static const uint kBoneRows = 0;     // 12 floats: 3 rows of [M | t]
static const uint kBoneColumns = 1;  // 16 floats: 4 columns of 4, of which the last row is not read
static const uint kBoneDualQuaternions = 2;  // 8 floats: rotation r, then the dual part t r / 2

cbuffer BoneConversionConstants : register(b0, space0) {
  uint g_convertedCount;    // bones; first: decision 0008
  uint g_engineBoneLayout;  // kBone... above
  uint g_engineBoneStride;  // floats from bone to bone
  uint g_engineBoneOffset;  // floats before the first one
  // xyz of the origin that converted bones are relative to, in world space [m]
  float4 g_boneOrigin;
  float4 g_boneOriginRest;  // xyz what rounding has left of it; 0 for whole meters
  uint g_convertToDual;     // 1: g_convertedBones has dual quaternions; 0: matrices
  uint g_boneConversionPad0;
  uint g_boneConversionPad1;
  uint g_boneConversionPad2;
};

// Bind space to world, written by the engine.
StructuredBuffer<float> g_engineBones : register(t0, space0);
// Bind space to the origin's: 3 rows of [M | t] a bone, or 2 quaternions (skinning/bones.hlsli).
RWStructuredBuffer<float4> g_convertedBones : register(u0, space0);

#endif
