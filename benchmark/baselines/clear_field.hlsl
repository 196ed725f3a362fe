// Classic baseline of distance fields, first pass (field_layout.hlsli).
// Threads: one a node. Writes g_fieldKeys.
#include "field_layout.hlsli"

[numthreads(64, 1, 1)]
void clear_field(uint3 thread : SV_DispatchThreadID) {
  uint node = nodeOf(thread);
  if (node < g_fieldNodes.w) g_fieldKeys[node] = toKey(kNothing);
}
