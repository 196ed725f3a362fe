// Resources of vertex skinning. Group "boneSkinning", all in space0.
//
// Positions are in buffers of floats, which may be an engine's own vertex buffers: three floats per
// vertex, at offset + stride * vertex.
#ifndef PELAGE_SKINNING_LAYOUTS_BONE_SKINNING_HLSLI
#define PELAGE_SKINNING_LAYOUTS_BONE_SKINNING_HLSLI

// The bones of one vertex: x..w index g_skinningBones (in bones), the weights sum to anything > 0.
struct VertexBinding {
  uint4 bones;
  float4 weights;
};

cbuffer BoneSkinningConstants : register(b0, space0) {
  uint g_skinnedCount;    // vertices
  uint g_skinningCount;   // bones
  uint g_skinningReset;   // 1: there is no last frame, g_skinned is not read
  uint g_bindStride;      // floats from vertex to vertex in g_bindVertices, >= 3
  uint g_bindOffset;      // floats before the first position
  uint g_skinnedStride;   // the same of g_skinned
  uint g_skinnedOffset;
  uint g_beforeStride;    // the same of g_skinnedBefore
  uint g_beforeOffset;
  uint g_dualQuaternions;  // 1: the bones are dual quaternions; 0: matrices
  uint g_skinningPad1;
  uint g_skinningPad2;
};

// Positions in the bind pose [m].
StructuredBuffer<float> g_bindVertices : register(t0, space0);
// [g_skinnedCount]
StructuredBuffer<VertexBinding> g_vertexBindings : register(t1, space0);
// Bind space to the space of the skinned positions: 3 rows of [M | t] a bone, or, with
// g_dualQuaternions, 2 quaternions a bone: the rotation r and the dual part t r / 2
// (skinning/bones.hlsli).
StructuredBuffer<float4> g_skinningBones : register(t2, space0);
// Positions of this frame [m].
RWStructuredBuffer<float> g_skinned : register(u0, space0);
// Positions of the last frame [m].
RWStructuredBuffer<float> g_skinnedBefore : register(u1, space0);

#endif
