// The root's pose and motion in a sub-step.
#ifndef PELAGE_SIMULATION_CLASSIC_STRAND_ROOT_HLSLI
#define PELAGE_SIMULATION_CLASSIC_STRAND_ROOT_HLSLI

#include "strand_memory.hlsli"

// Frame of the first segment in a pose.
float4 firstFrame(uint guide, RootPose pose) {
  float4 bind = g_rest[guideIndex(1, g_vertexCount - 1, guide)];
  return normalizeQuaternion(multiplyQuaternions(pose.rotation, bind));
}

// Direction of the first segment in a pose. Computed from the positions; the frame's x axis is the
// same, but loses digits if the segment runs against the bind space's x axis.
float3 firstDirection(uint guide, float3 bindRoot, RootPose pose, float4 rootFrame) {
  precise float3 segment = restPosition(1, guide) - bindRoot;
  return directionOr(rotate(pose.rotation, segment), rotate(rootFrame, float3(1.0, 0.0, 0.0)));
}

// A position of g_state, set 0 or 1, relative to this sub-step's origin.
float3 storedPosition(uint set, uint vertex, uint guide) {
  float share = (g_flags & kRebaseFlag) != 0u ? 1.0 : 0.0;
  precise float3 p = g_state[guideIndex(set, vertex, guide)].xyz + g_rebase.xyz * share;
  return p;
}

// A rigid motion: p -> p + rotationDelta(rotation, p - pivot) + shift.
struct Motion {
  float4 rotation;
  float3 pivot;
  float3 shift;
};

// Returns true if strands are transported by their root's motion.
bool propagatesShocks() { return g_vspCoefficient > 0.0 || g_vspThreshold < 3.402823e38; }

float3 transported(Motion motion, float3 p) {
  precise float3 r = p;
  if (propagatesShocks()) {
    precise float3 arm = p - motion.pivot;
    r = p + (rotationDelta(motion.rotation, arm) + motion.shift);
  }
  return r;
}

// Returns the point that transported() moves to here, up to rounding.
float3 untransported(Motion motion, float3 p) {
  precise float3 arm = p - motion.pivot - motion.shift;
  precise float3 r = motion.pivot + rotate(conjugate(motion.rotation), arm);
  return r;
}

Motion rootMotion(uint guide, RootPose begin, RootPose end) {
  Motion motion;
  motion.rotation = float4(0.0, 0.0, 0.0, 1.0);
  motion.pivot = begin.position;
  motion.shift = float3(0.0, 0.0, 0.0);
  if (!propagatesShocks()) return motion;
  // Acceleration of the root over two sub-steps of different length.
  float3 current = storedPosition(0, 0, guide);
  float3 previous = storedPosition(1, 0, guide);
  precise float share = g_vspCoefficient;
  if (isUsable(current) && isUsable(previous)) {
    precise float stepBefore = g_timeStep / g_timeStepRatio;
    precise float3 velocity = (end.position - current) / g_timeStep;
    precise float3 velocityBefore = (current - previous) / stepBefore;
    precise float3 change = (velocity - velocityBefore) * (2.0 / (g_timeStep + stepBefore));
    precise float acceleration = squareRoot(dot3(change, change));
    precise float excess = saturate(acceleration / g_vspThreshold - 1.0);
    // Smooth at both ends, so that no frame switches.
    precise float ramp = excess * excess * (3.0 - 2.0 * excess);
    share = share + (1.0 - share) * ramp;
  }
  share = saturate(share);
  float4 relativeRotation =
      normalizeQuaternion(multiplyQuaternions(end.rotation, conjugate(begin.rotation)));
  motion.rotation = interpolateQuaternions(float4(0.0, 0.0, 0.0, 1.0), relativeRotation, share);
  precise float3 shift = (end.position - begin.position) * share;
  motion.shift = shift;
  return motion;
}

#endif
