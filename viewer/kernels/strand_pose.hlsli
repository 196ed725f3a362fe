// Resources of posing strands for views of their errors, group "strandPose".
#ifndef VIEWER_STRAND_POSE_HLSLI
#define VIEWER_STRAND_POSE_HLSLI

#include "simulation/layouts/follow.hlsli"

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

#endif
