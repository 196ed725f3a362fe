// Gives each strand its share of the width with which level of detail draws it: 0 where it is left
// out, 1 where it does not fade.
//
// Threads: one per vertex of a posed strand, in rows of kInspectRow.
// Reads:   StrandDetailConstants
// Writes:  g_detailRecords (values)
//
// Invariant (viewer_test): as the width of strands in kernels/shading/drawn_fiber.hlsli.
#include "strand_detail.hlsli"
#include "strand_value.hlsli"

[numthreads(64, 1, 1)]
void mark_detail(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= g_detailVertices) return;
  float left = g_detailShown - float(index / g_detailVertexCount);
  float share = left > 0.0 ? kDetailDrawn : kDetailLeftOut;
  if (g_detailFading > 0.0) share = saturate(left / g_detailFading);
  g_detailRecords[index].w = share;
}
