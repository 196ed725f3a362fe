// The pose of a guide's root between two frames, from g_rootTransforms; with ROOTS_IN_STATE from
// the end of g_state, which a kernel has bound in any case.
#ifndef PELAGE_SIMULATION_ROOT_POSE_HLSLI
#define PELAGE_SIMULATION_ROOT_POSE_HLSLI

#include "layouts/simulation.hlsli"
#include "../base/quaternion.hlsli"

struct RootPose {
  float4 rotation;  // unit quaternion, bind space to world
  float3 position;  // of vertex 0 relative to g_origin [m]
};

bool isPose(RootTransform transform) { return isPose(transform.rotation, transform.position.xyz); }

#ifdef ROOTS_IN_STATE
RootTransform rootTransform(uint index) {
  uint end = kStateSets * g_vertexCount * g_guideCount;
  uint element = (end + kRootAlignment - 1u) / kRootAlignment * kRootAlignment + 2u * index;
  RootTransform transform;
  transform.rotation = g_state[element];
  transform.position = g_state[element + 1u];
  return transform;
}
#else
RootTransform rootTransform(uint index) { return g_rootTransforms[index]; }
#endif

// \param share 0 = the last frame, 1 = this frame.
RootPose rootPoseAt(uint guide, float3 bindRoot, float share) {
  RootTransform from = rootTransform(g_guideCount + guide);
  RootTransform to = rootTransform(guide);
  bool fromValid = isPose(from);
  bool toValid = isPose(to);
  RootPose pose;
  pose.rotation = float4(0.0, 0.0, 0.0, 1.0);
  precise float3 bindPosition = bindRoot - g_origin.xyz;
  pose.position = bindPosition;
  if (!fromValid && !toValid) return pose;
  if (!fromValid || share >= 1.0) from = to;
  if (!toValid || share <= 0.0) to = from;
  pose.rotation = interpolateQuaternions(normalizeQuaternion(from.rotation),
                                         normalizeQuaternion(to.rotation), share);
  precise float3 position =
      from.position.xyz + (to.position.xyz - from.position.xyz) * saturate(share);
  pose.position = position;
  return pose;
}

// Returns a point of the bind pose in a pose; relative to g_origin.
float3 targetPosition(RootPose pose, float3 bindRoot, float3 bindPosition) {
  precise float3 arm = bindPosition - bindRoot;
  precise float3 target = pose.position + rotate(pose.rotation, arm);
  return target;
}

#endif
