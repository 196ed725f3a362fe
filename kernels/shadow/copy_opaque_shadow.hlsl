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
#include "layouts/opaque_shadow.hlsli"

[numthreads(128, 1, 1)]
void copy_opaque_shadow(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_opaqueTexelCount) return;
  g_opaqueWords[g_opaqueFirstWord + index] = g_opaqueDepth[index];
}
