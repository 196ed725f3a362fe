// Resources of this engine's head. Its points are in world space; it receives the hair's shadow.
#ifndef ENGINE_SHADER_HEAD_LAYOUT_HLSLI
#define ENGINE_SHADER_HEAD_LAYOUT_HLSLI

#include "shading/layouts/strand_shadow_view.hlsli"

#define LIGHT_RIG_REGISTER register(b0, space0)
#include "light_rig.hlsli"

cbuffer HeadLook : register(b1, space0) {
  float4 g_headColor;  // linear rgb
  uint g_headVertexCount;
  uint g_headPad0;
  uint g_headPad1;
  uint g_headPad2;
};

StructuredBuffer<float4> g_headPositions : register(t0, space0);  // [vertex] [m]
StructuredBuffer<float4> g_headNormals : register(t1, space0);    // [vertex]
StructuredBuffer<uint> g_headShadowWords : register(t2, space0);
StructuredBuffer<StrandShadowView> g_headShadowViews : register(t3, space0);

struct HeadVaryings {
  float4 clip : SV_Position;
  float3 world : TEXCOORD0;
  float3 normal : TEXCOORD1;
};

#endif
