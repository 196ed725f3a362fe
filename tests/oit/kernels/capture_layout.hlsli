// Where fragments are captured to. Group "captureFragments", space2 behind RenderPosTan and Render.
#ifndef PELAGE_TESTS_OIT_CAPTURE_LAYOUT_HLSLI
#define PELAGE_TESTS_OIT_CAPTURE_LAYOUT_HLSLI

struct CapturedFragment {
  uint x;  // [pixels], in the view
  uint y;
  float depth;
  float alpha;
  float4 color;  // lit, linear rgb
};

cbuffer CaptureConstants : register(b0, space2) {
  uint g_captureCapacity;
  uint g_capturePad0;
  uint g_capturePad1;
  uint g_capturePad2;
};

RWStructuredBuffer<CapturedFragment> g_captured : register(u0, space2);
RWStructuredBuffer<uint> g_capturedCount : register(u1, space2);  // fragments, room or not

#endif
