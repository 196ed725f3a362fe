// Resources of measuring penetration, group "strandPenetration".
#ifndef VIEWER_STRAND_PENETRATION_HLSLI
#define VIEWER_STRAND_PENETRATION_HLSLI

cbuffer StrandPenetrationConstants : register(b0, space0) {
  uint g_depthVertexCount;   // vertices a strand
  uint g_depthVertices;      // of all strands that are posed
  uint g_depthCapsuleCount;
  uint g_depthGridCount;
  uint g_depthSlotCount;     // of g_depthSlots
  float g_depthLimit;        // [m] beyond which a vertex is counted
  uint g_depthPad0;
  uint g_depthPad1;
};

// [capsule][2]: xyz of an end in world space, w its radius [m]; then [grid][2]: xyz of node 0 in
// world space, w the cell size [m], and the counts of nodes (bits of uints).
StructuredBuffer<float4> g_depthColliders : register(t0, space0);
StructuredBuffer<uint4> g_depthSlots : register(t1, space0);  // HairBuffers::sdfs
StructuredBuffer<uint> g_depthKeys : register(t2, space0);    // Scene::sdfKeys()
RWStructuredBuffer<float4> g_depthRecords : register(u0, space0);  // as pose_strands writes them
RWStructuredBuffer<uint> g_depthSummary : register(u1, space0);    // kSummaryWords

#endif
