// Unsets all keys of an SDF and sets all of its crossings to 0.
//
// Threads: one for 4 keys and a word of crossings an axis, in rows of kRowGroups groups.
// Writes:  g_sdfKeys, g_sdfCounts
//
// Invariant (tests/sdf): no key of another SDF changes.
#include "sdf_key.hlsli"
#include "sdf_work.hlsli"

[numthreads(128, 1, 1)]
void clear_sdf(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint word = indexOfGroup(group) * 128u + lane;
  uint words = g_sdfNodes.x * g_sdfNodes.y * g_sdfNodes.z / 4u;
  if (word >= words) return;
  // Neighboring threads write neighboring words.
  for (uint part = 0; part < 4; ++part) g_sdfKeys[g_sdfNodes.w + part * words + word] = kSdfUnset;
  g_sdfCounts[word] = 0u;
  if (!hasThreeAxes()) return;
  g_sdfCounts[words + word] = 0u;
  g_sdfCounts[2u * words + word] = 0u;
}
