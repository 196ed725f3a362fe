// Writes where the vertices of the drawn strands are, follow hairs included, for views of values.
//
// Threads: one per vertex, in rows of kInspectRow.
// Reads:   g_posePositions; with g_poseEvaluatesFollows g_poseFollowHairs and g_poseRoots
// Writes:  g_poseRecords
//
// Invariant (viewer_test): a guide's vertex is where HairBuffers::positions has it; a vertex that is
// not finite, or of a follow hair without a guide, has no value and is far away.
#include "strand_pose.hlsli"
#include "strand_value.hlsli"
#define STRAND_POSITIONS g_posePositions
#define STRAND_VERTEX_COUNT g_poseVertexCount
#define STRAND_FOLLOW_HAIRS g_poseFollowHairs
#define STRAND_ROOTS g_poseRoots
#define STRAND_GUIDE_COUNT g_poseGuideCount
#define STRAND_EVALUATES_FOLLOWS (g_poseEvaluatesFollows != 0u)
#define STRAND_TIP_SEPARATION g_poseTipSeparation
#include "shading/drawn_strand.hlsli"

[numthreads(64, 1, 1)]
void pose_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= g_poseStrandCount * g_poseVertexCount) return;
  uint strand = index / g_poseVertexCount;
  DrawnVertex drawn = drawnVertex(strand, index - strand * g_poseVertexCount);
  bool known = drawn.known && isUsable(drawn.position);
  g_poseRecords[index] = float4(known ? drawn.position : float3(kNoValue, 0.0, 0.0), kNoValue);
}
