// Writes depth of strands, and with MOTION how far they have moved on the screen since the last
// frame. The depth test keeps the nearest fragment.
//
// Reads:   StrandPixel, with MOTION MotionPixel; StrandDepthConstants, StrandViewConstants
// Writes:  depth; SV_Target0: x depth 0..1, yzw (0, 0, 1). With MOTION xy motion [pixels], x to the
//          right and y down, z depth, w 1.
//
// A fragment whose opacity times coverage is below g_depthOpacity is left out. A point that was
// behind the eye gets a motion that leads outside of the last picture.
//
// Invariant (tests/shading): depth is that of the fiber within 1e-4; the motion of a rigid strand
// is the analytic one, and exactly 0 where nothing has moved.
#include "../layouts/render.hlsli"
#include "../layouts/strand_depth.hlsli"
#include "motion_interface.hlsli"
#define SMOOTH 0
#include "../strand_interface.hlsli"

// Motion beyond it is cut [pixels]: 16-bit floats end at 65504.
static const float kMaxMotion = 32768.0;

// \param pixel position in the viewport, row 0 the top row; \param motion MotionPixel.motion.
float2 motionOf(float2 pixel, float4 motion) {
  float2 size = g_viewport.zw;
  if (!(motion.w > 1e-6)) return size * 2.0;
  float2 at = float2(pixel.x / size.x * 2.0 - 1.0, 1.0 - pixel.y / size.y * 2.0);
  float2 moved = (motion.xy - at * motion.z) / motion.w;
  float2 pixels = moved * float2(0.5, -0.5) * size - g_jitterChange;
  return clamp(pixels, float2(-kMaxMotion, -kMaxMotion), float2(kMaxMotion, kMaxMotion));
}

#if MOTION
float4 strand_depth_pixel(MotionPixel strand) : SV_Target0 {
  float alpha = strand.alpha.x * strand.alpha.y;
  if (!(alpha > 0.0 && alpha >= g_depthOpacity)) discard;
  return float4(motionOf(strand.clip.xy - g_viewport.xy, strand.motion), strand.clip.z, 1.0);
}
#else
float4 strand_depth_pixel(StrandPixel strand) : SV_Target0 {
  // Always true; Vulkan's layers warn of outputs of a vertex kernel that are not read.
  if (!(dot(strand.tangent, strand.tangent) + float(strand.strand) >= 0.0)) discard;
  float alpha = strand.color.a * strand.ribbon.x;
  if (!(alpha > 0.0 && alpha >= g_depthOpacity)) discard;
  return float4(strand.clip.z, 0.0, 0.0, 1.0);
}
#endif
