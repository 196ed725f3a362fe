// Empties the lists of all pixels; see classic_list_layout.hlsli.
#include "classic_list_layout.hlsli"

[numthreads(128, 1, 1)]
void clear_classic_list(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint x = group.x * 128u + lane;
  uint y = group.y;
  if (x >= g_classicWidth || y >= g_classicHeight) return;
  g_classicHeads[y * g_classicWidth + x] = 0u;
  if (x == 0u && y == 0u) g_classicCounter[0] = 0u;
}
