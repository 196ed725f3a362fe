// Writes the positions of the drawn strands' vertices, follow hairs included, for views of values.
//
// Threads: one per vertex, in rows of kInspectRow.
// Reads:   g_posePositions; with g_poseEvaluatesFollows g_poseFollowHairs and g_poseRoots
// Writes:  g_poseRecords
//
// Invariant (viewer_test): a guide's vertex is where HairBuffers::positions has it; a vertex that
// is not finite, or of a follow hair without a guide, has no value and is far away.
#include "simulation/layouts/follow.hlsli"
#include "strand_value.hlsli"

cbuffer StrandPoseConstants : register(b0, space0) {
  uint g_poseVertexCount;       // vertices a strand
  uint g_poseGuideCount;        // the strands from here on are follow hairs
  uint g_poseStrandCount;       // strands that are posed, from the first
  uint g_poseEvaluatesFollows;  // 1: follow hairs are not in g_posePositions
  float g_poseTipSeparation;    // SimulationSettings::tipSeparation
  uint g_posePad0;
  uint g_posePad1;
  uint g_posePad2;
};

// HairBuffers::positions, followHairRecords, rootTransforms(). The last two are read where follow
// hairs are evaluated.
StructuredBuffer<float4> g_posePositions : register(t0, space0);
StructuredBuffer<FollowHairRecord> g_poseFollowHairs : register(t1, space0);
StructuredBuffer<RootTransform> g_poseRoots : register(t2, space0);

// [strand][vertex] xyz world position [m], w value: kNoValue until it is measured.
RWStructuredBuffer<float4> g_poseRecords : register(u0, space0);

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
