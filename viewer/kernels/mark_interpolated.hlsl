// Marks the guides that level of detail does not simulate, among those that are drawn. The exact
// solver has sorted its strands: it simulates the first ones.
//
// Threads: one per vertex of a guide, in rows of kInspectRow; the first ones of a strand in the
//          solver's order.
// Reads:   g_detailRest
// Writes:  g_detailRecords (values)
//
// Invariant (viewer_test): as many guides as HairObject::simulatedShare leaves out.
#include "strand_detail.hlsli"
#include "strand_value.hlsli"

[numthreads(64, 1, 1)]
void mark_interpolated(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  uint strand = index / g_detailVertexCount;
  if (strand < g_detailSimulatedCount || strand >= g_detailGuideCount) return;
  // ExactStrand: {state, count, target, root}, {seed, ...}.
  uint guide = g_detailRest[g_detailFirstStrand + kExactStrandElements * strand].w;
  if (guide >= g_detailGuideCount) return;
  uint record = guide * g_detailVertexCount + index % g_detailVertexCount;
  if (g_detailRecords[record].w > kDetailLeftOut) g_detailRecords[record].w = kDetailInterpolated;
}
