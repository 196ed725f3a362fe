// Takes the number of fragments of each tile from those that kTiles has sorted.
//
// Threads: one per tile of the list of tiles that have hair, in rows of kInspectRow.
// Reads:   g_tileWords, g_tileCounters
// Writes:  g_tileCounts
//
// Invariant (viewer_test): the counts add up to the method's own counter, where all have room.
#include "strand_value.hlsli"
#include "tile_counts.hlsli"
#include "oit/tiles/strand_tile_counters.hlsli"

[numthreads(64, 1, 1)]
void count_tile_fragments(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= min(g_tileCounters[kTileInstancesWord], g_tileCount)) return;
  uint tile = g_tileWords[2u * g_tileCount + index];
  if (tile >= g_tileCount) return;
  uint count = g_tileWords[tile];
  // A tile without room is in the list, and empty.
  g_tileCounts[tile] = count > 0u ? count : kTileWithoutRoom;
}
