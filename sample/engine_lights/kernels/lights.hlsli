// The lights of this engine on hair, in place of pelage's: pelage_add_engine_lights() compiles this
// into the kernels of every transparency method.
#define RIG_SPACE ENGINE_LIGHTS_SPACE
#include "rig.hlsli"

float3 engineLight(StrandShading material, StrandSurface surface) {
  // pelage: the share of the sun that the hair in front lets through. The sun is light 0 of the
  // view for the sake of this map.
  float open = 1.0;
  StrandLight sun = lightAt(0u);
  if (g_lightCount > 0u && sun.shadow.x < kMaxStrandShadows)
    open = strandTransmittance(shadowAt(sun.shadow.x), surface.position);

  float3 sunlight = g_rigSunColor.rgb * (open * sunVisibility(surface.position));
  float3 light = sunlight * shadeStrand(material, surface, g_rigSun.xyz);
  SpotLight spot = spotAt(surface.position);
  light += spot.color * shadeStrand(material, surface, spot.toLight);

  // The side of the fiber that the camera sees faces this way.
  float3 front = surface.toEye - surface.tangent * dot(surface.tangent, surface.toEye);
  return light + skyOn(unitOr(front, surface.toEye)) * strandAmbient(material, surface);
}
