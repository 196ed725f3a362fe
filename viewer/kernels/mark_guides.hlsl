// Gives guides the value 1 and follow hairs 0.
//
// Threads: one per vertex of a posed strand, in rows of kInspectRow.
// Reads:   StrandStretchConstants
// Writes:  g_stretchRecords (values)
//
// Invariant (viewer_test): every vertex that is posed has one of the two values.
#include "strand_stretch.hlsli"
#include "strand_value.hlsli"

[numthreads(64, 1, 1)]
void mark_guides(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index < g_stretchPosed) g_stretchRecords[index].w = index < g_stretchVertices ? 1.0 : 0.0;
}
