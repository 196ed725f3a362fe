// Pixel stage of this engine's head: a Lambert surface in the same light, with the shadow that the
// hair casts on it.
#include "head_layout.hlsli"
#define SHADOW_WORDS g_headShadowWords
#include "shading/strand_shadow.hlsli"

float4 head_pixel(HeadVaryings head) : SV_Target0 {
  float3 normal = head.normal * rsqrt(max(dot(head.normal, head.normal), 1e-20));
  float open = 1.0;
  if (g_keyDirection.w > 0.0) open = strandTransmittance(g_headShadowViews[0], head.world);
  float3 light = g_keyColor.rgb * (open * max(dot(normal, g_keyDirection.xyz), 0.0)) +
                 g_rimColor.rgb * max(dot(normal, g_rimDirection.xyz), 0.0) + hemisphere(normal);
  return float4(light * g_headColor.rgb, 1.0);
}
