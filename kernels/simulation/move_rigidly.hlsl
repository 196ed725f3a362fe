// Moves the data that a hair object keeps between frames, for a teleport: states, roots, contact
// records and positions of the last frame.
//
// Threads: one an element, in rows of 2^20.
// Reads:   g_movedElements
// Writes:  g_movedElements
//
// Invariant (tests/simulation): points, directions and quaternions are those of the moved object to
// rounding; w of points and directions, and the elements before g_movedFirst and behind the last
// one, keep their bits.
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"
#include "layouts/move_rigidly.hlsli"

[numthreads(64, 1, 1)]
void move_rigidly(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_movedCount) return;
  uint block = (index / max(g_movedBlock, 1u)) % max(g_movedPeriod, 1u);
  uint kind = (g_movedKinds >> (kMovedKindBits * block)) & ((1u << kMovedKindBits) - 1u);
  uint4 old = g_movedElements[g_movedFirst + index];
  float4 value = asfloat(old);
  uint4 moved;
  if (kind == kMovesFrame) {
    precise float4 product = multiplyQuaternions(g_moveRotation, value);
    // One step of Newton towards the length of 1; an element that was never written stays 0.
    precise float squared = dot4(product, product);
    bool unit = squared > 0.9 && squared < 1.1;
    precise float4 polished = product * (1.5 - 0.5 * squared);
    float4 frame = unit ? polished : product;
    moved = asuint(frame);
  } else {
    precise float3 rotated = rotate(g_moveRotation, value.xyz);
    precise float3 shifted = rotated + g_moveShift.xyz;
    float3 result = kind == kMovesPoint ? shifted : rotated;
    moved = uint4(asuint(result), old.w);
  }
  g_movedElements[g_movedFirst + index] = moved;
}
