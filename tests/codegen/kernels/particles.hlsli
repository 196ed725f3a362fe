// Resources of the fixture's group "particles". The registers are not dense and not in order, so
// that the numbers of the plan differ from them.
#ifndef FIXTURE_PARTICLES_HLSLI
#define FIXTURE_PARTICLES_HLSLI

#include "shared/limits.hlsli"

struct Particle {
  float4 position;
  float2 size;
  uint kind;
  int lives;
  uint2 cell;
  float history[3];
  uint last;
};

struct Well {
  float4 center;
  float strength;
  float radius;
};

RWStructuredBuffer<Particle> g_particles : register(u3, space0);
RWStructuredBuffer<uint> g_cellCounts : register(u1, space0);

cbuffer ForceConstants : register(b2, space1) {
  float4 g_planes[2];
  float3 g_gravity;
  float g_timeStep;
  uint g_particleCount;
  int g_wellCount;
  float2 g_drag;
  int2 g_gridOrigin;
  uint g_lastOne;
  float4 g_window;  // 4 bytes behind the member before it
};

StructuredBuffer<Well> g_wells : register(t5, space1);
RWStructuredBuffer<float4> g_trail : register(u0, space1);
RWByteAddressBuffer g_log : register(u2, space1);
Texture2D<float4> g_noise : register(t0, space1);
SamplerState g_noiseSampler : register(s1, space1);
// No kernel uses it, so no table has it.
StructuredBuffer<float4> g_forgotten : register(t1, space1);

#endif
