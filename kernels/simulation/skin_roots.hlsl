// Computes the rigid frame of every guide root: the blend of up to four bones at the bind position
// of vertex 0.
//
// Threads: one per guide strand; dispatch g_guideCount x 1.
// Reads:   g_rootBindings, g_boneTransforms, g_rest (vertex 0), g_rootTransforms (this frame's)
// Writes:  g_rootTransforms: this frame's to the last frame's half, then the new one. With the
//          reset flag both halves get the new one.
// Run it once a simulated frame, before the sub-steps.
//
// Position: the blended map applied to the bind root, which keeps the root on a skin that the same
// bones move. Rotation: bones.hlsli; dual quaternions are blended as rigid motions.
//
// Invariant (tests/simulation): the rotation is a unit quaternion and the position is finite for
// every input. Bones past the end and weights that are not > 0 add nothing; if none is left, the
// binding's first bone has weight 1. A root whose bones hold a NaN or an infinity, or do not exist,
// stays at its position in the last frame (in the bind pose if there was none); a root whose bones
// have no volume keeps its last rotation.
#include "layouts/simulation.hlsli"
#define BONE_TRANSFORMS g_boneTransforms
#define BONE_COUNT g_boneCount
#include "../skinning/bones.hlsli"
#include "root_pose.hlsli"
#include "strand_indexing.hlsli"

// The transform if no bone is usable.
RootTransform keptTransform(RootTransform last, float3 bindRoot) {
  if (isPose(last)) return last;
  RootTransform bind;
  bind.rotation = float4(0.0, 0.0, 0.0, 1.0);
  precise float3 position = bindRoot - g_origin.xyz;
  bind.position = float4(position, 0.0);
  return bind;
}

[numthreads(64, 1, 1)]
void skin_roots(uint3 thread : SV_DispatchThreadID) {
  uint guide = thread.x;
  if (guide >= g_guideCount) return;

  float3 bindRoot = g_rest[guideIndex(0, 0, guide)].xyz;
  RootTransform last = g_rootTransforms[guide];
  precise float3 rebased = last.position.xyz + g_rebase.xyz;
  last.position = float4(rebased, 0.0);
  RootTransform kept = keptTransform(last, bindRoot);
  RootTransform next = kept;

  RootBinding binding = g_rootBindings[guide];
  uint4 bones = binding.bones;
  float4 weights = weightsOfBones(bones, binding.weights);

  if ((g_flags & kDualQuaternionsFlag) != 0u) {
    RigidMotion motion;
    if (blendDualQuaternions(bones, weights, motion)) {
      next.rotation = motion.rotation;
      next.position = float4(moveRigidly(motion, bindRoot), 0.0);
    }
  } else {
    MatrixBlend blend;
    if (blendMatrices(bones, weights, blend)) {
      next.rotation = rotationOfBlend(blend, kept.rotation);
      next.position = float4(moveByBlend(blend, bindRoot), 0.0);
    }
  }

  // Sums of huge numbers may overflow although each of them was usable.
  if (!isPose(next)) next = kept;
  g_rootTransforms[guide] = next;
  RootTransform previous = kept;
  if ((g_flags & kResetFlag) != 0u) previous = next;
  g_rootTransforms[g_guideCount + guide] = previous;
}
