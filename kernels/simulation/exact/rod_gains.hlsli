// The control law of an edge, u = -k - Kx dx + Kw u_-1, and how it waits in memory from the
// elimination to the roll-out, with the length of the edge and half of the turn of its guess: 22
// floats and 3 of 21 bits, in 6 float4.
#ifndef PELAGE_SIMULATION_EXACT_ROD_GAINS_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_GAINS_HLSLI

#include "rod_state.hlsli"

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
  float3 halfTurn;
};

struct PackedGain {
  float4 a;
  float4 b;
  float4 c;
  float4 d;
  float4 e;
  float4 f;
};

// Three shortened floats in two places.
float2 packTurn(float3 v) {
  uint3 bits = asuint(v);
  return float2(asfloat(bits.x | (bits.z >> 21)), asfloat(bits.y | ((bits.z >> 11) & 0x3ffu)));
}
float3 unpackTurn(float2 p) {
  uint2 bits = asuint(p);
  return float3(asfloat(bits.x & 0xfffff800u), asfloat(bits.y & 0xfffff800u),
                asfloat((bits.x << 21) | ((bits.y & 0x3ffu) << 11)));
}

void storeGain(uint vertex, ExactStrand strand, Gain g) {
  g_gains[stateIndex(0, vertex, strand)] = float4(g.k, g.kx0.x);
  g_gains[stateIndex(1, vertex, strand)] = float4(g.kx0.yz, g.kx1.xy);
  g_gains[stateIndex(2, vertex, strand)] = float4(g.kx1.z, g.kx2);
  g_gains[stateIndex(3, vertex, strand)] = float4(g.kw0, g.kw1.x);
  g_gains[stateIndex(4, vertex, strand)] = float4(g.kw1.yz, g.kw2.xy);
  g_gains[stateIndex(5, vertex, strand)] = float4(g.kw2.z, g.edgeLength, packTurn(g.halfTurn));
}

PackedGain loadGain(uint vertex, ExactStrand strand) {
  PackedGain p;
  p.a = g_gains[stateIndex(0, vertex, strand)];
  p.b = g_gains[stateIndex(1, vertex, strand)];
  p.c = g_gains[stateIndex(2, vertex, strand)];
  p.d = g_gains[stateIndex(3, vertex, strand)];
  p.e = g_gains[stateIndex(4, vertex, strand)];
  p.f = g_gains[stateIndex(5, vertex, strand)];
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
  g.halfTurn = unpackTurn(p.f.zw);
  return g;
}

#endif
