// Shades an iso surface so that its shape is visible: wrapped Lambert on the outside, a warning
// color on the inside, which shows where the surface is open or inside out.
//
// Reads:   RenderMeshConstants
// Writes:  SV_Target0 premultiplied linear color and opacity
//
// Invariant (tests/sdf): finite for every normal; brighter towards the light; the outside never
// has the color of the inside.
#include "layouts/render_mesh.hlsli"

// Fraction of the light that wraps past the terminator, so that the dark side still shows its
// shape.
static const float kWrap = 0.5;
static const float3 kInsideColor = float3(0.55, 0.02, 0.25);

float3 unitOf(float3 v) { return v * rsqrt(max(dot(v, v), 1e-20)); }

float4 iso_surface_pixel(MeshVaryings input) : SV_Target0 {
  float3 normal = unitOf(input.normal);
  bool outside = dot(normal, g_meshEye.xyz - input.position) >= 0.0;
  if (!outside) normal = -normal;
  float facing = max((dot(normal, g_meshLightDirection.xyz) + kWrap) / (1.0 + kWrap), 0.0);
  float3 light = g_meshLightColor.rgb * facing + g_meshAmbientColor.rgb;
  float3 color = (outside ? g_meshColor.rgb : kInsideColor) * light;
  return float4(color * g_meshColor.a, g_meshColor.a);
}
