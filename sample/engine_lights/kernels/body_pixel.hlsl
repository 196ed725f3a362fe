// Pixel stage of this engine's body: a Lambert surface in the light that its hair is in.
#include "body_layout.hlsli"

float4 body_pixel(BodyVaryings body) : SV_Target0 {
  float3 normal = body.normal * rsqrt(max(dot(body.normal, body.normal), 1e-20));
  SpotLight spot = spotAt(body.world);
  float3 light =
      g_rigSunColor.rgb * (sunVisibility(body.world) * max(dot(normal, g_rigSun.xyz), 0.0)) +
      spot.color * max(dot(normal, spot.toLight), 0.0) + skyOn(normal);
  return float4(light * g_bodyColor.rgb, 1.0);
}
