// Resources of showing level of detail, group "strandDetail".
#ifndef VIEWER_STRAND_DETAIL_HLSLI
#define VIEWER_STRAND_DETAIL_HLSLI

cbuffer StrandDetailConstants : register(b0, space0) {
  uint g_detailVertexCount;  // vertices a strand
  uint g_detailVertices;     // of all strands that are posed
  float g_detailShown;       // DrawnStrands::shown
  float g_detailFading;      // DrawnStrands::fading
  uint g_detailGuideCount;
  uint g_detailSimulatedCount;  // guides that are simulated
  uint g_detailFirstStrand;     // element of the first ExactStrand in g_detailRest
  uint g_detailPad0;
};

StructuredBuffer<uint4> g_detailRest : register(t0, space0);        // HairBuffers::rest
RWStructuredBuffer<float4> g_detailRecords : register(u0, space0);  // as pose_strands writes them

// Elements of a guide in g_detailRest.
static const uint kExactStrandElements = 2;

// Values of strands. Strands that fade have values between the first two.
static const float kDetailLeftOut = 0.0;
static const float kDetailDrawn = 1.0;
static const float kDetailInterpolated = 2.0;  // drawn, and a guide that is not simulated

#endif
