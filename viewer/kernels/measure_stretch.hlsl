// Measures how much longer than at rest the edges of guides are: length / rest length - 1, of the
// two edges at a vertex the one that is further off.
//
// Threads: one per vertex of a guide, in rows of kInspectRow.
// Reads:   g_restLengths, g_stretchRecords (positions)
// Writes:  g_stretchRecords (values), g_stretchSummary
//
// Edges of less than a micrometer have no stretch: files pad strands with them.
// Invariant (viewer_test): the exact solver's edges are as long as at rest to 1e-3.
#include "strand_stretch.hlsli"
#include "strand_value.hlsli"
#include "base/quaternion.hlsli"

static const float kShortestEdge = 1e-6;  // [m]

float stretchOf(uint edge) {
  float rest = g_restLengths[edge];
  if (!(rest > kShortestEdge)) return 0.0;
  float3 along = g_stretchRecords[edge + 1u].xyz - g_stretchRecords[edge].xyz;
  return sqrt(dot(along, along)) / rest - 1.0;
}

[numthreads(64, 1, 1)]
void measure_stretch(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= g_stretchVertices) return;
  uint vertex = index % g_stretchVertexCount;
  uint before;
  InterlockedAdd(g_stretchSummary[kSummaryMeasured], 1u, before);
  if (!isUsable(float4(g_stretchRecords[index].xyz, 0.0)) ||
      g_stretchRecords[index].x > kMostValue) {
    InterlockedAdd(g_stretchSummary[kSummaryNotFinite], 1u, before);
    return;
  }
  float own = vertex + 1u < g_stretchVertexCount ? stretchOf(index) : 0.0;
  float other = vertex > 0u ? stretchOf(index - 1u) : 0.0;
  float value = abs(own) > abs(other) ? own : other;
  if (!(abs(value) < kMostValue)) value = kMostValue * 0.5;
  g_stretchRecords[index].w = value;
  InterlockedMax(g_stretchSummary[kSummaryLargest], asuint(abs(value)), before);
  if (abs(value) > g_stretchLimit) InterlockedAdd(g_stretchSummary[kSummaryBeyond], 1u, before);
}
