// Classic baseline of distance fields, third pass (field_layout.hlsli).
// Threads: one a node. Reads and writes g_fieldKeys.
#include "field_layout.hlsli"

[numthreads(64, 1, 1)]
void finish_field(uint3 thread : SV_DispatchThreadID) {
  uint node = nodeOf(thread);
  if (node < g_fieldNodes.w) g_fieldKeys[node] = asuint(fromKey(g_fieldKeys[node]));
}
