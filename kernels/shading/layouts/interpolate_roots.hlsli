// Resources of interpolate_roots. Group "interpolateRoots", all in space0.
#ifndef PELAGE_SHADING_LAYOUTS_INTERPOLATE_ROOTS_HLSLI
#define PELAGE_SHADING_LAYOUTS_INTERPOLATE_ROOTS_HLSLI

#include "../../simulation/layouts/follow.hlsli"

cbuffer InterpolateRootsConstants : register(b0, space0) {
  uint g_interpolatedRoots;     // guides
  float g_interpolatedRootShare;  // 0: the state before, 1: the state now
  uint g_rootsRestart;            // 0 or 1: what was drawn before is what is drawn now
  uint g_rootsPad0;
};

// [2][guide]: root frames of the last state (0) and the one before (1).
StructuredBuffer<RootTransform> g_stateRoots : register(t0, space0);
// [2][guide]: those that are drawn (0), and those that were drawn before (1).
RWStructuredBuffer<RootTransform> g_drawnRoots : register(u0, space0);

#endif
