// Sums the counts of all tiles: the fullest one, tiles with hair, all of them, tiles without room.
//
// Threads: one per tile, in rows of kInspectRow.
// Reads:   g_tileCounts
// Writes:  g_tileSummary
//
// Invariant (viewer_test): tiles with hair <= the sum of the counts, where all have room.
#include "strand_value.hlsli"
#include "tile_counts.hlsli"

[numthreads(64, 1, 1)]
void sum_tile_counts(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= g_tileCount) return;
  uint count = g_tileCounts[index];
  if (count == 0u) return;
  uint before;
  InterlockedAdd(g_tileSummary[kTilesWithHair], 1u, before);
  if (count == kTileWithoutRoom) {
    InterlockedAdd(g_tileSummary[kTilesWithoutRoom], 1u, before);
    return;
  }
  InterlockedMax(g_tileSummary[kTileMost], count, before);
  InterlockedAdd(g_tileSummary[kTileTotal], count, before);
}
