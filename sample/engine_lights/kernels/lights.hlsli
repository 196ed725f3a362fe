// The lights of this engine on hair, in place of pelage's: pelage_add_engine_lights() compiles this
// into the kernels of every transparency method.
#define RIG_SPACE ENGINE_LIGHTS_SPACE
#include "rig.hlsli"

float3 engineLight(StrandShading material, StrandSurface surface) {
  // pelage: the hair in front of the strand and behind it. The sun is light 0 of the view for the
  // sake of this map.
  StrandLightPath path = openLightPath();
  StrandLight sun = lightAt(0u);
  if (g_lightCount > 0u && sun.shadow.x < kMaxStrandShadows)
    path = strandLightPath(shadowAt(sun.shadow.x), surface.position);

  StrandVolume volume = strandVolumeOf(material, surface);
  float3 sunlight = g_rigSunColor.rgb * sunVisibility(surface.position);
  float3 light = sunlight * shadeStrandInHair(material, surface, g_rigSun.xyz, volume, path);
  SpotLight spot = spotAt(surface.position);
  light += spot.color * shadeStrandInHair(material, surface, spot.toLight, volume, openLightPath());

  // The side of the fiber that the camera sees faces this way.
  float3 front = surface.toEye - surface.tangent * dot(surface.tangent, surface.toEye);
  return light + skyOn(unitOr(front, surface.toEye)) * strandAmbient(material, surface);
}
