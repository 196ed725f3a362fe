// Resources of the classic baseline of transparency: per-pixel linked lists with a buffer of the 8
// nearest fragments, as their behaviour is known. Group "classicListBuild", space2 behind
// RenderPosTan and Render; classic_list_read_layout.hlsli has those of the resolve.
//   clear_classic_list  empties lists and counter
//   classic_list_build  a node a fragment, of 16 bytes: next, depth, tangent and coverage in 8 bits
//                       each, colour in 8 bits a channel
//   classic_list_read   one walk that keeps the nearest; what falls out is blended as it comes
// It keeps what makes it what it is: 8 bits are cut, not rounded; a fragment without room empties
// the list of its pixel; past the nearest 8 the order of arrival decides; 8 slots are lit whatever
// is in them; 512 fragments of a pixel are seen. Left out is what would be undefined: nodes beyond
// the pool are not written.
#ifndef BASELINE_CLASSIC_LIST_LAYOUT_HLSLI
#define BASELINE_CLASSIC_LIST_LAYOUT_HLSLI

cbuffer ClassicListBuildConstants : register(b0, space2) {
  uint g_classicWidth;   // [pixels]
  uint g_classicHeight;  // [pixels]
  uint g_classicCapacity;
  uint g_classicPad;
};

// [y][x]: place of the pixel's first node + 1, or 0.
RWStructuredBuffer<uint> g_classicHeads : register(u0, space2);
// {next as in g_classicHeads, bits of the depth, tangent and coverage, colour}
RWStructuredBuffer<uint4> g_classicNodes : register(u1, space2);
// Nodes that were asked for.
RWStructuredBuffer<uint> g_classicCounter : register(u2, space2);

#endif
