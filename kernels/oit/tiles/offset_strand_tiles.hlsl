// Turns the sums of the blocks into prefix sums, and writes the arguments of
// the draw and of dispatches.
//
// Threads: one group of 128, each thread a run of blocks.
// Reads:   g_binSums
// Writes:  g_binSums, g_binCounters
#include "strand_tile_counters.hlsli"
#include "strand_tile_sums.hlsli"

[numthreads(128, 1, 1)]
void offset_strand_tiles(uint lane : SV_GroupIndex) {
  uint blocks = binBlocks();
  uint share = (blocks + 127u) / 128u;
  uint begin = min(lane * share, blocks);
  uint end = min(begin + share, blocks);
  uint2 own = uint2(0u, 0u);
  for (uint i = begin; i < end; ++i) own = saturatingSum(own, g_binSums[i]);
  uint2 all = sumUpTo(lane, own);
  uint2 before = uint2(0u, 0u);
  if (lane > 0u) before = s_sums[lane - 1u];
  for (uint block = begin; block < end; ++block) {
    uint2 sum = g_binSums[block];
    g_binSums[block] = before;
    before = saturatingSum(before, sum);
  }
  if (lane == 127u) {
    g_binCounters[kTileDrawWord] = 6u;
    g_binCounters[kTileInstancesWord] = all.y;
    g_binCounters[2] = 0u;
    g_binCounters[3] = 0u;
    g_binSums[blocks] = uint2(0u, all.y);
    uint pixels = pixelsOfGroup(all.x, all.y);
    g_binSums[blocks + 1u] = uint2(pixels, 0u);
    g_binCounters[kTileFragmentsWord] = all.x;
    g_binCounters[kTileDispatchWord] = min(all.y, kTileDispatchRow);
    g_binCounters[kTileDispatchWord + 1u] = (all.y + kTileDispatchRow - 1u) / kTileDispatchRow;
    g_binCounters[kTileDispatchWord + 2u] = 64u / pixels;
  }
}
