// Makes all keys of a field unset and all of its crossings 0.
//
// Threads: one for 4 keys and a word of crossings an axis, in rows of kGroupsARow groups.
// Writes:  g_sdfKeys, g_sdfCounts
//
// Invariant (tests/kernel): no key of another field changes.
#include "sdf_key.hlsli"
#include "sdf_work.hlsli"

[numthreads(128, 1, 1)]
void clear_sdf(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint word = indexOfGroup(group) * 128u + lane;
  uint words = g_fieldNodes.x * g_fieldNodes.y * g_fieldNodes.z / 4u;
  if (word >= words) return;
  // Neighbouring threads write neighbouring words.
  for (uint part = 0; part < 4; ++part)
    g_sdfKeys[g_fieldNodes.w + part * words + word] = kSdfUnset;
  g_sdfCounts[word] = 0u;
  if (!hasThreeAxes()) return;
  g_sdfCounts[words + word] = 0u;
  g_sdfCounts[2u * words + word] = 0u;
}
