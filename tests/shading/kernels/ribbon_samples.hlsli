// Resources of the kernels that evaluate the strand geometry. Group "ribbon": space0 Ribbon.
#ifndef PELAGE_TESTS_RIBBON_SAMPLES_HLSLI
#define PELAGE_TESTS_RIBBON_SAMPLES_HLSLI

#include "shading/strand_common.hlsli"

struct RibbonSample {
  float4 position;  // w radius
  float4 tangent;   // w side
};

struct RibbonResult {
  float4 smoothClip;  // of expandStrandRibbon
  float4 clip;        // of expandStrandVertex
  float4 values;      // distance, half width, coverage of the vertex
};

cbuffer RibbonConstants : register(b0, space0) {
  float4 g_ribbonClip[4];
  float4 g_ribbonEye;
  float4 g_ribbonViewport;  // zw size [pixels]
  uint g_ribbonCount;
  uint g_ribbonPad0;
  uint g_ribbonPad1;
  uint g_ribbonPad2;
};
StructuredBuffer<RibbonSample> g_ribbonSamples : register(t0, space0);
// [g_ribbonCount]: distance, half width
StructuredBuffer<float2> g_pixelSamples : register(t1, space0);
RWStructuredBuffer<RibbonResult> g_ribbonResults : register(u0, space0);
RWStructuredBuffer<float> g_pixelCoverage : register(u1, space0);

#endif
