// The pose of a guide's root between two frames, from g_rootTransforms.
#ifndef PELAGE_COMMON_ROOT_POSE_HLSLI
#define PELAGE_COMMON_ROOT_POSE_HLSLI

#include "../layouts/simulation.hlsli"
#include "quaternion.hlsli"

struct RootPose {
  float4 rotation;  // unit quaternion, bind space to world
  float3 position;  // of vertex 0 relative to g_origin [m]
};

bool isPose(RootTransform transform) { return isPose(transform.rotation, transform.position.xyz); }

// \param share 0 = the last frame, 1 = this frame.
RootPose rootPoseAt(uint guide, float3 bindRoot, float share) {
  RootTransform from = g_rootTransforms[g_guideCount + guide];
  RootTransform to = g_rootTransforms[guide];
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

// Where the bind pose has a point, in a pose; relative to g_origin.
float3 goalPosition(RootPose pose, float3 bindRoot, float3 bindPosition) {
  precise float3 arm = bindPosition - bindRoot;
  precise float3 goal = pose.position + rotate(pose.rotation, arm);
  return goal;
}

#endif
