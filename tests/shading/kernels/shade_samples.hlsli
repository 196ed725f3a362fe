// Resources of the kernels that evaluate the shading functions. Group "shade": space0 Shade.
#ifndef PELAGE_TESTS_SHADE_SAMPLES_HLSLI
#define PELAGE_TESTS_SHADE_SAMPLES_HLSLI

#include "shading/layouts/shading.hlsli"
#include "shading/strand_lighting.hlsli"

struct ShadeSample {
  float4 tangent;  // w material
  float4 toEye;
  float4 base;   // w offset across the fiber
  float4 light;  // as StrandLight.direction
};

cbuffer ShadeConstants : register(b0, space0) {
  uint g_shadeCount;  // samples
  uint g_materialCount;
  uint g_thetaCount;  // sum_light: directions of light a sample, along and around the fiber
  uint g_phiCount;
};
StructuredBuffer<ShadeSample> g_shadeSamples : register(t0, space0);
StructuredBuffer<StrandShading> g_shadeMaterials : register(t1, space0);
// [g_shadeCount], for sum_light times g_thetaCount
RWStructuredBuffer<float4> g_shaded : register(u0, space0);

StrandShading materialOf(ShadeSample s) {
  return g_shadeMaterials[min(uint(s.tangent.w), g_materialCount - 1u)];
}

// As it is given, be it of length 1 or not.
StrandSurface surfaceOf(ShadeSample s) {
  StrandSurface surface;
  surface.uv = float2(0.0, 0.0);
  surface.position = float3(0.0, 0.0, 0.0);
  surface.tangent = s.tangent.xyz;
  surface.toEye = s.toEye.xyz;
  surface.baseColor = s.base.xyz;
  surface.offset = s.base.w;
  return surface;
}

#endif
