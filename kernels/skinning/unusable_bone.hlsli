// Bones that skinning does not use.
#ifndef PELAGE_SKINNING_UNUSABLE_BONE_HLSLI
#define PELAGE_SKINNING_UNUSABLE_BONE_HLSLI

// A bone with this number: what it moves stays where it was, because it is above 1e18
// (base/quaternion.hlsli). A NaN might not arrive: drivers may assume that there is none.
static const float kUnusable = 1e30;
float4 unusableRow() { return float4(kUnusable, kUnusable, kUnusable, kUnusable); }

#endif
