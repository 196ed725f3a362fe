// Resources of the runtime tests' draws. Group "runtime_draw":
//   space0 RuntimeDraw
#ifndef PELAGE_TESTS_RUNTIME_DRAW_HLSLI
#define PELAGE_TESTS_RUNTIME_DRAW_HLSLI

cbuffer FillConstants : register(b0, space0) {
  float4 g_color;   // linear rgba
  float4 g_offset;  // added to each clip position
};

// [vertex]: clip position (y up, depth 0..1).
StructuredBuffer<float4> g_corners : register(t0, space0);

#endif
