// The light of this engine: a sky, a key light with a shadow of the hair, a rim light from behind.
// Define LIGHT_RIG_REGISTER before you include this. All of it is the engine's.
#ifndef ENGINE_SHADER_LIGHT_RIG_HLSLI
#define ENGINE_SHADER_LIGHT_RIG_HLSLI

cbuffer LightRig : LIGHT_RIG_REGISTER {
  float4 g_cameraRows[4];  // world to clip; y up, depth 0..1
  float4 g_cameraEye;      // xyz [m]
  float4 g_cameraTarget;   // xy size [pixels], z samples a pixel
  float4 g_keyDirection;   // xyz unit vector towards the light; w number of its shadow maps, 0 or 1
  float4 g_keyColor;       // linear rgb
  float4 g_rimDirection;
  float4 g_rimColor;
  float4 g_skyColor;     // light from above
  float4 g_groundColor;  // light from below
};

// Light of the sky and the ground on what faces this way.
float3 hemisphere(float3 normal) {
  return lerp(g_groundColor.rgb, g_skyColor.rgb, 0.5 + 0.5 * normal.y);
}

float4 toClip(float3 world) {
  float4 p = float4(world, 1.0);
  return float4(dot(g_cameraRows[0], p), dot(g_cameraRows[1], p), dot(g_cameraRows[2], p),
                dot(g_cameraRows[3], p));
}

#endif
