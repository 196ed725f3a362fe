// Gives every guide root its rigid frame: the blend of up to four bones at the bind position of
// vertex 0.
//
// Threads: one a guide strand; dispatch g_guideCount x 1.
// Reads:   g_rootBindings, g_boneTransforms, g_rest (vertex 0), g_rootTransforms (this frame's)
// Writes:  g_rootTransforms: this frame's to the last frame's half, then the new one. With the
//          reset flag both halves get the new one.
// Run it once a simulated frame, before the sub-steps.
//
// Position: the blended map applied to the bind root, which keeps the root on a skin that the same
// bones move. Rotation: bones.hlsli; DUAL_QUATERNIONS blends rigid motions instead of matrices.
//
// Invariant (tests/kernel): the rotation is a unit quaternion and the position is finite for every
// input. Bones past the end and weights that are not > 0 add nothing; where none is left, the
// binding's first bone has weight 1. A root whose bones hold a NaN or an infinity, or do not exist,
// stays where it was in the last frame (in the bind pose when there was none); one whose bones have
// no volume keeps its last rotation.
#include "../common/bones.hlsli"
#include "../common/root_pose.hlsli"
#include "../common/strand_indexing.hlsli"

// The transform when there are no bones that can be used.
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
  float4 weights = binding.weights;
  if (!boneCounts(bones.x, weights.x) && !boneCounts(bones.y, weights.y) &&
      !boneCounts(bones.z, weights.z) && !boneCounts(bones.w, weights.w))
    weights = float4(1.0, 0.0, 0.0, 0.0);

#if DUAL_QUATERNIONS
  uint strongest = bones.x;
  float strongestWeight = 0.0;
  if (boneCounts(bones.x, weights.x)) strongestWeight = weights.x;
  if (boneCounts(bones.y, weights.y) && weights.y > strongestWeight) {
    strongest = bones.y;
    strongestWeight = weights.y;
  }
  if (boneCounts(bones.z, weights.z) && weights.z > strongestWeight) {
    strongest = bones.z;
    strongestWeight = weights.z;
  }
  if (boneCounts(bones.w, weights.w) && weights.w > strongestWeight) {
    strongest = bones.w;
    strongestWeight = weights.w;
  }
  if (strongestWeight > 0.0) {
    float4 pivot = g_boneTransforms[strongest * 2];
    DualBlend blend;
    blend.real = float4(0.0, 0.0, 0.0, 0.0);
    blend.dual = float4(0.0, 0.0, 0.0, 0.0);
    blend.usable = true;
    blend = addDualBone(blend, bones.x, weights.x, pivot);
    blend = addDualBone(blend, bones.y, weights.y, pivot);
    blend = addDualBone(blend, bones.z, weights.z, pivot);
    blend = addDualBone(blend, bones.w, weights.w, pivot);
    if (blend.usable) {
      // No bone points away from the pivot, so the sum is at least as long as its own weight.
      float inverse = inverseRoot(max(dot4(blend.real, blend.real), 1e-24));
      precise float4 real = blend.real * inverse;
      precise float4 dual = blend.dual * inverse;
      float4 moved = multiplyQuaternions(dual, conjugate(real));
      float4 rotation = normalizeQuaternion(real);
      precise float3 position = rotate(rotation, bindRoot) + moved.xyz * 2.0;
      next.rotation = rotation;
      next.position = float4(position, 0.0);
    }
  }
#else
  MatrixBlend blend = emptyMatrixBlend();
  blend = addMatrixBone(blend, bones.x, weights.x);
  blend = addMatrixBone(blend, bones.y, weights.y);
  blend = addMatrixBone(blend, bones.z, weights.z);
  blend = addMatrixBone(blend, bones.w, weights.w);
  if (blend.weightSum > 0.0 && blend.usable) {
    blend = normalizeBlend(blend);
    precise float x = dot3(blend.sum.a.xyz, bindRoot) + blend.sum.a.w;
    precise float y = dot3(blend.sum.b.xyz, bindRoot) + blend.sum.b.w;
    precise float z = dot3(blend.sum.c.xyz, bindRoot) + blend.sum.c.w;
    next.rotation = rotationOfBlend(blend, kept.rotation);
    next.position = float4(x, y, z, 0.0);
  }
#endif

  // Sums of huge numbers may overflow although each of them was usable.
  if (!isPose(next)) next = kept;
  g_rootTransforms[guide] = next;
  RootTransform previous = kept;
  if ((g_flags & 1u) != 0u) previous = next;
  g_rootTransforms[g_guideCount + guide] = previous;
}
