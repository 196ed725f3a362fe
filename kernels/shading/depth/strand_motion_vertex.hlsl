// Draws a strand as strand_vertex does without SMOOTH, for depth and motion.
//
// Vertices: as those of strand_vertex
// Reads:    what strand_vertex reads, g_previousPositions, g_renderRoots of the last frame,
//           StrandDepthConstants
// Writes:   MotionPixel
//
// Invariant (tests/shading): the ribbon is that of strand_vertex; where neither strand nor camera
// have moved, the motion is exactly 0.
#include "strand_motion.hlsli"

MotionPixel strand_motion_vertex(uint corner : SV_VertexID, uint strand : SV_InstanceID) {
  MotionPixel result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.motion = float4(0.0, 0.0, 0.0, 1.0);
  result.alpha = float2(0.0, 0.0);
  uint vertex = corner >> 1;
  if (vertex >= g_renderVertexCount || strand >= g_renderStrandCount) return result;
  DrawnFiber fiber = drawnFiber(strand, vertex);
  if (!fiber.known) return result;

  float side = (corner & 1u) != 0u ? 1.0 : -1.0;
  StrandCorner expanded =
      expandStrandVertex(renderView(), fiber.position, fiber.tangent, fiber.radius, side);
  result.clip = expanded.clip;
  result.alpha = float2(fiber.color.a, expanded.coverage);
  float3 change = clipMotion(fiber.position, previousPosition(strand, vertex, fiber.position));
  result.motion = float4(change, expanded.clip.w - change.z);
  return result;
}
