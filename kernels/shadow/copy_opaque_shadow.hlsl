// Copies a depth map of opaque geometry to the shadow maps of hair, so that whatever shades hair
// reads one buffer.
//
// Threads: one per texel, in rows of 2^20.
// Reads:   g_opaqueDepth
// Writes:  its words of g_opaqueWords
//
// Invariant (tests/shadow/opaque_shadow_test): the words of the map are the depths' bits, and no
// other word changes.
#include "../base/dispatch.hlsli"

cbuffer OpaqueShadowConstants : register(b0, space0) {
  uint g_opaqueTexelCount;
  uint g_opaqueFirstWord;  // of the map in g_opaqueWords
  uint g_opaquePad0;
  uint g_opaquePad1;
};

// [y][x]: the bits of depths 0..1, from the engine.
StructuredBuffer<uint> g_opaqueDepth : register(t0, space0);
// All maps, see shading/layouts/opaque_shadow_view.hlsli.
RWStructuredBuffer<uint> g_opaqueWords : register(u0, space0);

[numthreads(128, 1, 1)]
void copy_opaque_shadow(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_opaqueTexelCount) return;
  g_opaqueWords[g_opaqueFirstWord + index] = g_opaqueDepth[index];
}
