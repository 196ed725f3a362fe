#ifndef FIXTURE_DRAW_HLSLI
#define FIXTURE_DRAW_HLSLI

cbuffer DrawConstants : register(b0, space0) {
  float4 g_worldToClip[4];
  float4 g_color;
};
StructuredBuffer<float4> g_points : register(t0, space0);

struct PointOutput {
  float4 clip : SV_Position;
  float4 color : COLOR0;
};

#endif
