// The control law of an edge, u = -k - Kx dx + Kw u_-1, and its packing in memory from the
// elimination to the roll-out, with the length of the edge and half of the rotation of its guess:
// 22 floats and 3 of 21 bits, in 6 float4.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_GAINS_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_GAINS_HLSLI

#include "exact_state.hlsli"

// Columns of the matrices.
struct Gain {
  float3 k;
  float3 kx0;
  float3 kx1;
  float3 kx2;
  float3 kw0;
  float3 kw1;
  float3 kw2;
  float edgeLength;
  float3 halfRotation;
};

// A gain's response to forces: their moment q about the edge e adds W q to k.
struct Response {
  Symmetric3 w;
  float3 e;
};

struct PackedGain {
  float4 a;
  float4 b;
  float4 c;
  float4 d;
  float4 e;
  float4 f;
};

// Three shortened floats in two words.
float2 packRotation(float3 v) {
  uint3 bits = asuint(v);
  return float2(asfloat(bits.x | (bits.z >> 21)), asfloat(bits.y | ((bits.z >> 11) & 0x3ffu)));
}
float3 unpackRotation(float2 p) {
  uint2 bits = asuint(p);
  return float3(asfloat(bits.x & 0xfffff800u), asfloat(bits.y & 0xfffff800u),
                asfloat((bits.x << 21) | ((bits.y & 0x3ffu) << 11)));
}

// Element of a vertex in the first set of gains.
uint gainIndex(uint vertex, ExactStrand strand) {
  return firstGainElement() + stateIndex(0, vertex, strand);
}

void storeGain(uint vertex, ExactStrand strand, Gain g) {
  uint element = gainIndex(vertex, strand);
  g_state[element + 0u * g_stateStride] = float4(g.k, g.kx0.x);
  g_state[element + 1u * g_stateStride] = float4(g.kx0.yz, g.kx1.xy);
  g_state[element + 2u * g_stateStride] = float4(g.kx1.z, g.kx2);
  g_state[element + 3u * g_stateStride] = float4(g.kw0, g.kw1.x);
  g_state[element + 4u * g_stateStride] = float4(g.kw1.yz, g.kw2.xy);
  g_state[element + 5u * g_stateStride] =
      float4(g.kw2.z, g.edgeLength, packRotation(g.halfRotation));
}

PackedGain loadGain(uint vertex, ExactStrand strand) {
  uint element = gainIndex(vertex, strand);
  PackedGain p;
  p.a = g_state[element + 0u * g_stateStride];
  p.b = g_state[element + 1u * g_stateStride];
  p.c = g_state[element + 2u * g_stateStride];
  p.d = g_state[element + 3u * g_stateStride];
  p.e = g_state[element + 4u * g_stateStride];
  p.f = g_state[element + 5u * g_stateStride];
  return p;
}

Gain unpackGain(PackedGain p) {
  Gain g;
  g.k = p.a.xyz;
  g.kx0 = float3(p.a.w, p.b.xy);
  g.kx1 = float3(p.b.zw, p.c.x);
  g.kx2 = p.c.yzw;
  g.kw0 = p.d.xyz;
  g.kw1 = float3(p.d.w, p.e.xy);
  g.kw2 = float3(p.e.zw, p.f.x);
  g.edgeLength = p.f.y;
  g.halfRotation = unpackRotation(p.f.zw);
  return g;
}

// Returns the rotation of an edge by its control law.
// \param k of the law, or 0 for differences of states
float3 controlLaw(Gain g, float3 k, float3 u, float3 dx) {
  precise float3 law =
      g.kw0 * u.x + g.kw1 * u.y + g.kw2 * u.z - k - g.kx0 * dx.x - g.kx1 * dx.y - g.kx2 * dx.z;
  return law;
}

#endif
