// Moves the vertices of a mesh with up to four bones each.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_bindVertices, g_vertexBindings, g_skinningBones, g_skinned (this frame's)
// Writes:  g_skinnedBefore: what g_skinned had, the positions of the last frame; then g_skinned.
//          With g_skinningReset both get the new positions. The floats between the positions stay.
//
// The blended map applied to the bind position; dual quaternions are blended as rigid motions
// (skinning/bones.hlsli). Positions are in buffers of floats, which may be an engine's own vertex
// buffers: three floats per vertex, at offset + stride * vertex.
//
// Invariant (tests/skinning): bones past the end and weights that are not > 0 add nothing; if none
// is left, the binding's first bone has weight 1. A vertex whose bones hold a NaN or an infinity,
// or do not exist, stays at its position in the last frame (in the bind pose if there was none). If
// the bind position is not a number, neither is the skinned one, so readers of the mesh can leave
// its triangles out.
// The bones of one vertex: x..w index g_skinningBones (in bones), the weights sum to anything > 0.
struct VertexBinding {
  uint4 bones;
  float4 weights;
};

cbuffer BoneSkinningConstants : register(b0, space0) {
  uint g_skinnedCount;   // vertices
  uint g_skinningCount;  // bones
  uint g_skinningReset;  // 1: there is no last frame, g_skinned is not read
  uint g_bindStride;     // floats from vertex to vertex in g_bindVertices, >= 3
  uint g_bindOffset;     // floats before the first position
  uint g_skinnedStride;  // the same of g_skinned
  uint g_skinnedOffset;
  uint g_beforeStride;  // the same of g_skinnedBefore
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

#define BONE_TRANSFORMS g_skinningBones
#define BONE_COUNT g_skinningCount
#include "bones.hlsli"
#include "../base/dispatch.hlsli"

float3 skinnedPosition(uint vertex, float3 bind, float3 kept) {
  VertexBinding binding = g_vertexBindings[vertex];
  float4 weights = weightsOfBones(binding.bones, binding.weights);
  float3 moved = kept;
  if (g_dualQuaternions != 0u) {
    RigidMotion motion;
    if (blendDualQuaternions(binding.bones, weights, motion)) moved = moveRigidly(motion, bind);
  } else {
    MatrixBlend blend;
    if (blendMatrices(binding.bones, weights, blend)) moved = moveByBlend(blend, bind);
  }
  // Also for a bind position that is none, and for sums of huge numbers.
  return isUsable(moved) ? moved : kept;
}

[numthreads(64, 1, 1)]
void skin_vertices(uint3 thread : SV_DispatchThreadID) {
  uint vertex = indexOfThread(thread);
  if (vertex >= g_skinnedCount) return;

  uint source = g_bindOffset + g_bindStride * vertex;
  uint target = g_skinnedOffset + g_skinnedStride * vertex;
  uint before = g_beforeOffset + g_beforeStride * vertex;
  float3 bind =
      float3(g_bindVertices[source], g_bindVertices[source + 1], g_bindVertices[source + 2]);
  float3 last = float3(g_skinned[target], g_skinned[target + 1], g_skinned[target + 2]);
  bool hasLast = g_skinningReset == 0u && isUsable(last);
  float3 kept = hasLast ? last : bind;
  float3 next = skinnedPosition(vertex, bind, kept);
  float3 previous = hasLast ? last : next;

  g_skinned[target] = next.x;
  g_skinned[target + 1] = next.y;
  g_skinned[target + 2] = next.z;
  g_skinnedBefore[before] = previous.x;
  g_skinnedBefore[before + 1] = previous.y;
  g_skinnedBefore[before + 2] = previous.z;
}
