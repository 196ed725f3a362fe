// Resources of drawing depth and motion of strands. Group "strandDepth" (space2 after RenderPosTan
// and Render).
#ifndef PELAGE_SHADING_LAYOUTS_STRAND_DEPTH_HLSLI
#define PELAGE_SHADING_LAYOUTS_STRAND_DEPTH_HLSLI

cbuffer StrandDepthConstants : register(b0, space2) {
  float g_depthOpacity;           // fragments below it are left out, 0..1
  float g_previousTipSeparation;  // g_renderTipSeparation in the last frame
  float2 g_jitterChange;          // of the camera's jitter since the last frame [pixels], y down
  // Rows x, y and w of the map from world to clip space, minus those of the last frame.
  float4 g_clipChange[3];
  uint g_previousRoots;      // element of g_renderRoots where the poses of the last frame begin
  uint g_motionRecordCount;  // records of this object in g_motionRecords
  uint g_depthPad0;
  uint g_depthPad1;
};

// [strand][vertex], as many as g_renderPositions: where they were in the last frame [m].
StructuredBuffer<float4> g_previousPositions : register(t0, space2);
// [vertex][3], see shading/strand_record.hlsli and shading/depth/strand_motion.hlsli.
RWStructuredBuffer<uint4> g_motionRecords : register(u0, space2);

#endif
