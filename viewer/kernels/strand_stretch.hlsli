// Resources of measuring stretch, group "strandStretch".
#ifndef VIEWER_STRAND_STRETCH_HLSLI
#define VIEWER_STRAND_STRETCH_HLSLI

cbuffer StrandStretchConstants : register(b0, space0) {
  uint g_stretchVertexCount;  // vertices a strand
  uint g_stretchVertices;     // of all guides
  float g_stretchLimit;       // magnitude beyond which a vertex is counted
  uint g_stretchPosed;        // vertices of all strands that are posed
};

StructuredBuffer<float> g_restLengths : register(t0, space0);        // [guide][vertex] [m]
RWStructuredBuffer<float4> g_stretchRecords : register(u0, space0);  // as pose_strands writes them
RWStructuredBuffer<uint> g_stretchSummary : register(u1, space0);    // kSummaryWords

#endif
