// Resources of this engine's body, whose vertices are in world space.
#ifndef ENGINE_LIGHTS_BODY_LAYOUT_HLSLI
#define ENGINE_LIGHTS_BODY_LAYOUT_HLSLI

#define RIG_SPACE space0
#include "rig.hlsli"

cbuffer BodyLook : register(b1, space0) {
  float4 g_bodyRows[4];  // world to clip; y up, depth 0..1
  float4 g_bodyColor;    // linear rgb
};

struct BodyVertex {
  [[vk::location(0)]] float4 position : ATTRIBUTE0;  // xyz [m]
  [[vk::location(1)]] float4 normal : ATTRIBUTE1;  // xyz
};

struct BodyVaryings {
  float4 clip : SV_Position;
  float3 world : TEXCOORD0;
  float3 normal : TEXCOORD1;
};

#endif
