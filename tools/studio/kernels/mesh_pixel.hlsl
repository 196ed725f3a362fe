// Shades a mesh like unglazed clay: wrapped Lambert, an ambient term that is brighter from above, a
// broad faint highlight. Linear color, opaque. With SHADOWED, hair in front shadows the light, and
// the ambient term in part.
//
// One thread a pixel. Reads the constants; with SHADOWED g_meshShadowWords and g_meshShadowViews.
// Invariant: finite for every normal, and brighter where the surface faces the light.
#include "mesh.hlsli"
#if SHADOWED
#define SHADOW_WORDS g_meshShadowWords
#include "shading/strand_shadow.hlsli"
#endif

// Light that reaches past the terminator, as it does through skin: 0 is Lambert, 1 a full wrap.
static const float kWrap = 0.35;
static const float kHighlight = 0.10;
static const float kHighlightExponent = 14.0;
// Fresnel term of Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994), eq.
// 15, for a refractive index of 1.4.
static const float kReflectance = 0.028;

float3 unit(float3 v) { return v * rsqrt(max(dot(v, v), 1e-20)); }

float4 mesh_pixel(MeshVaryings input) : SV_Target {
  float3 eye = unit(g_eye.xyz - input.world);
  float3 normal = unit(input.normal);
  float3 light = g_lightDirection.xyz;

  float facing = (dot(normal, light) + kWrap) / (1.0 + kWrap);
  float diffuse = max(facing, 0.0);
  diffuse = diffuse * diffuse;
  float3 arriving = g_lightColor.rgb;
  float3 ambient = g_ambientColor.rgb * (0.75 + 0.25 * normal.y);
  float3 reflected = g_ambientColor.rgb * 0.5;
#if SHADOWED
  // Hair that keeps the light away covers the skin from about half of all directions.
  float open = softTransmittance(g_meshShadowViews[0], input.world);
  arriving *= open;
  ambient *= 0.5 + 0.5 * open;
  reflected *= open;
#endif

  float3 middle = unit(light + eye);
  float grazing = 1.0 - saturate(dot(eye, normal));
  float fresnel =
      kReflectance + (1.0 - kReflectance) * grazing * grazing * grazing * grazing * grazing;
  float highlight = kHighlight * pow(max(dot(normal, middle), 1e-4), kHighlightExponent) * diffuse;

  float2 covered = saturate(input.covered);
  float3 albedo =
      lerp(lerp(g_skinColor.rgb, g_scalpColor.rgb, covered.x), g_coatColor.rgb, covered.y);
  float3 color =
      albedo * (arriving * diffuse + ambient) +
      (1.0 - covered.x) * (1.0 - covered.y) * (arriving * highlight + reflected * fresnel);
  return float4(color, 1.0);
}
