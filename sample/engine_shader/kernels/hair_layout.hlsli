// Resources of this engine's hair shaders, and what the vertex stage hands to the pixel stage.
#ifndef ENGINE_SHADER_HAIR_LAYOUT_HLSLI
#define ENGINE_SHADER_HAIR_LAYOUT_HLSLI

#include "shading/layouts/strand_shadow_view.hlsli"

#define LIGHT_RIG_REGISTER register(b0, space0)
#include "light_rig.hlsli"

cbuffer HairLook : register(b1, space0) {
  float4 g_lookRoot;  // linear rgb; a = opacity
  float4 g_lookTip;   // linear rgb
  float4 g_lookBody;  // members of StrandShading
  float4 g_lookPrimary;
  float4 g_lookSecondary;
  float g_lookRootRadius;  // [m]
  float g_lookTipRadius;
  uint g_lookVertexCount;  // vertices a strand
  uint g_lookStrandCount;
};

// The four buffers that are pelage's: HairBuffers::positions and tangents, [strand][vertex];
// Scene::shadowWords() and shadowViews().
StructuredBuffer<float4> g_hairPositions : register(t0, space0);
StructuredBuffer<float4> g_hairTangents : register(t1, space0);
StructuredBuffer<uint> g_hairShadowWords : register(t2, space0);
StructuredBuffer<StrandShadowView> g_hairShadowViews : register(t3, space0);

struct HairVaryings {
  float4 clip : SV_Position;
  float3 world : TEXCOORD0;
  float3 tangent : TEXCOORD1;
  float3 color : TEXCOORD2;
  float alpha : TEXCOORD3;
  nointerpolation uint strand : TEXCOORD4;
};

#endif
