// Counts the nodes of the lists of each tile's pixels: kWindowed. Fragments without a node are not
// in any list.
//
// Threads: one per pixel of the view, in rows of kInspectRow.
// Reads:   g_tileHeads, g_tileListNodes
// Writes:  g_tileCounts
//
// Invariant (viewer_test): the counts add up to the method's own counter, where all have room.
#include "strand_value.hlsli"
#include "tile_counts.hlsli"
#include "oit/fragment_packing.hlsli"

[numthreads(64, 1, 1)]
void count_tile_nodes(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= uint(g_valueArea.z) * uint(g_valueArea.w)) return;
  uint count = 0u;
  uint node = g_tileHeads[index];
  // Bounds the walk: a list is at most as long as the buffer of nodes.
  while (node > 0u && node <= g_tileNodes && count < g_tileNodes) {
    ++count;
    node = nextOf(g_tileListNodes[node - 1u].x);
  }
  if (count == 0u) return;
  uint2 at = uint2(index % g_tileWidth, index / g_tileWidth);
  InterlockedAdd(g_tileCounts[(at.y >> kTileShift) * g_tileColumns + (at.x >> kTileShift)], count);
}
