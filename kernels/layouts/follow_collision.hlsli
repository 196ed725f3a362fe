// Resources of the collision of stored follow strands. Group "followCollision", all in space0.
//
// Sizes: S strands, of which the last F are follow strands; V vertices a strand.
#ifndef PELAGE_LAYOUTS_FOLLOW_COLLISION_HLSLI
#define PELAGE_LAYOUTS_FOLLOW_COLLISION_HLSLI

#include "collider.hlsli"
#include "sdf_field.hlsli"

cbuffer FollowCollisionConstants : register(b0, space0) {
  float4 g_followOrigin;     // xyz of what fields and colliders are relative to, in world space [m]
  uint g_firstFollow;        // strand
  uint g_followStrandCount;  // F
  uint g_followVertexCount;  // V, 2..256
  uint g_followFieldCount;
  uint g_followColliderCount;
  uint g_followHistory;  // 1: g_followBefore is that of the last frame; 0: it is not known
  uint g_followPad0;
  uint g_followPad1;
};

// [strand][vertex], S * V: world position [m]; w = inverse mass, > 0 for a free vertex.
RWStructuredBuffer<float4> g_followPositions : register(u0, space0);
// [strand][vertex], S * V: unit tangent; w = 0.
RWStructuredBuffer<float4> g_followTangents : register(u1, space0);
// [follow][vertex], F * V: world position at the end of the last frame [m]; w unused.
RWStructuredBuffer<float4> g_followBefore : register(u2, space0);
// With the sdf permutation: [g_followFieldCount], and what they refer to.
StructuredBuffer<SdfField> g_followFields : register(t0, space0);
StructuredBuffer<uint> g_followKeys : register(t1, space0);
StructuredBuffer<uint4> g_followSurface : register(t2, space0);
// [g_followColliderCount]
StructuredBuffer<Collider> g_followColliders : register(t3, space0);

#endif
