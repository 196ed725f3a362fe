// Pixel stage of an engine's own hair shader: its lights around pelage's shading and shadow.
#include "hair_layout.hlsli"
#include "shading/strand_coverage.hlsli"
#include "shading/strand_lighting.hlsli"
// The shadow's functions read the maps from this buffer.
#define SHADOW_WORDS g_hairShadowWords
#include "shading/strand_shadow.hlsli"

struct HairSample {
  float4 color : SV_Target0;
  uint coverage : SV_Coverage;
};

StrandShading engineShading() {
  StrandShading shading;
  shading.model = uint4(kStrandKajiyaKay, 0u, 0u, 0u);
  shading.body = g_lookBody;
  shading.primary = g_lookPrimary;
  shading.secondary = g_lookSecondary;
  shading.fiber = float4(0.3, 0.3, 0.0, 1.55);  // for kStrandFiber
  return shading;
}

HairSample hair_pixel(HairVaryings hair) {
  HairSample result;
  // pelage: as many samples of the pixel as the strand covers; sorts by the depth test alone.
  uint samples = uint(g_cameraTarget.z);
  result.coverage = strandSamples(hair.alpha, samples, hair.strand, hair.clip.xy, 0u);
  if (result.coverage == 0u) discard;

  StrandShading shading = engineShading();
  StrandSurface surface = makeStrandSurface(hair.world, hair.tangent, g_cameraEye.xyz, hair.color);

  // pelage: the share of the key light that the hair in front lets through.
  float open = 1.0;
  if (g_keyDirection.w > 0.0) open = strandTransmittance(g_hairShadowViews[0], hair.world);
  float3 light = g_keyColor.rgb * open * shadeStrand(shading, surface, g_keyDirection.xyz);
  light += g_rimColor.rgb * shadeStrand(shading, surface, g_rimDirection.xyz);

  // The side of the fiber that the camera sees faces this way.
  float3 front = surface.toEye - surface.tangent * dot(surface.tangent, surface.toEye);
  light += hemisphere(unitOr(front, surface.toEye)) * strandAmbient(shading, surface);
  result.color = float4(light, 1.0);
  return result;
}
