// View and lights of strands. Each layout that needs it has its own block: the including file
// defines STRAND_VIEW_REGISTER before.
#ifndef PELAGE_SHADING_LAYOUTS_STRAND_VIEW_HLSLI
#define PELAGE_SHADING_LAYOUTS_STRAND_VIEW_HLSLI

#include "opaque_shadow_view.hlsli"
#include "shading.hlsli"
#include "strand_shadow_view.hlsli"

cbuffer StrandViewConstants : STRAND_VIEW_REGISTER {
  float4 g_worldToClip[4];  // rows; clip = rows * (p, 1), depth 0..1, y up
  float4 g_clipToWorld[4];  // rows of its inverse
  float4 g_eye;             // xyz position of the camera [m]
  float4 g_viewport;        // xy offset, zw size [pixels]
  float4 g_ambientColor;    // linear rgb
  uint g_lightCount;        // at most 8
  uint g_reversedDepth;     // 0 or 1
  uint g_sampleCount;       // samples per pixel of the target
  uint g_seed;              // seed of the coverage dither
  // Members of StrandLight, [light]; uint4 of StrandLight.shadow.
  float4 g_lightDirections[8];
  float4 g_lightColors[8];
  uint4 g_lightShadows[8];
  // Members of StrandShadowView, [shadow]: mapX to mapW; width, height, firstWord, layerCount;
  // layerRange, bias, extinction, texelSize; tauScale, tauQuantum, maxRadius, nearW.
  float4 g_shadowRows[16];
  uint4 g_shadowSizes[4];
  float4 g_shadowDepths[4];
  float4 g_shadowScales[4];
  uint4 g_shadowFaces[4];  // x faceCount, y the bits of across
  float4 g_lightCones[8];  // StrandLight.cone, [light]
  // Members of OpaqueShadowView, [shadow]: clipX to clipW; width, height, firstWord, reversedDepth;
  // bias.
  float4 g_opaqueRows[16];
  uint4 g_opaqueSizes[4];
  float4 g_opaqueBiases[4];
  // Light from all sides, linear rgb: g_ambientColor plus a sum of these times polynomials of the
  // direction, y, z, x, x y, y z, 3 z^2 - 1, x z, x^2 - y^2.
  float4 g_environment[8];
};

// Radiance that a fiber receives: the mean over all directions, weighted by the sine of their angle
// to the fiber (Kajiya and Kay 1989), by which band 2 counts -1/8 of its value along the fiber and
// band 1 cancels out (docs/shading.md).
float3 environmentOnFiber(float3 t) {
  float3 along = g_environment[3].rgb * (t.x * t.y) + g_environment[4].rgb * (t.y * t.z) +
                 g_environment[5].rgb * (3.0 * t.z * t.z - 1.0) +
                 g_environment[6].rgb * (t.x * t.z) +
                 g_environment[7].rgb * (t.x * t.x - t.y * t.y);
  return max(g_ambientColor.rgb - 0.125 * along, float3(0.0, 0.0, 0.0));
}

// Half of the change of radiance from -d to d.
float3 environmentSlope(float3 d) {
  return g_environment[0].rgb * d.y + g_environment[1].rgb * d.z + g_environment[2].rgb * d.x;
}

StrandLight lightAt(uint index) {
  StrandLight light;
  light.direction = g_lightDirections[index];
  light.color = g_lightColors[index];
  light.shadow = g_lightShadows[index];
  light.cone = g_lightCones[index];
  return light;
}

StrandShadowView shadowAt(uint index) {
  StrandShadowView map;
  map.mapX = g_shadowRows[4u * index];
  map.mapY = g_shadowRows[4u * index + 1u];
  map.mapZ = g_shadowRows[4u * index + 2u];
  map.mapW = g_shadowRows[4u * index + 3u];
  map.width = g_shadowSizes[index].x;
  map.height = g_shadowSizes[index].y;
  map.firstWord = g_shadowSizes[index].z;
  map.layerCount = g_shadowSizes[index].w;
  map.layerRange = g_shadowDepths[index].x;
  map.bias = g_shadowDepths[index].y;
  map.extinction = g_shadowDepths[index].z;
  map.texelSize = g_shadowDepths[index].w;
  map.tauScale = g_shadowScales[index].x;
  map.tauQuantum = g_shadowScales[index].y;
  map.maxRadius = g_shadowScales[index].z;
  map.nearW = g_shadowScales[index].w;
  map.faceCount = g_shadowFaces[index].x;
  map.across = asfloat(g_shadowFaces[index].y);
  map.pad1 = 0u;
  map.pad2 = 0u;
  return map;
}

OpaqueShadowView opaqueShadowAt(uint index) {
  OpaqueShadowView map;
  map.clipX = g_opaqueRows[4u * index];
  map.clipY = g_opaqueRows[4u * index + 1u];
  map.clipZ = g_opaqueRows[4u * index + 2u];
  map.clipW = g_opaqueRows[4u * index + 3u];
  map.width = g_opaqueSizes[index].x;
  map.height = g_opaqueSizes[index].y;
  map.firstWord = g_opaqueSizes[index].z;
  map.reversedDepth = g_opaqueSizes[index].w;
  map.bias = g_opaqueBiases[index].x;
  map.pad0 = 0u;
  map.pad1 = 0u;
  map.pad2 = 0u;
  return map;
}

StrandShading shadingFrom(uint model, float4 body, float4 primary, float4 secondary, float4 fiber) {
  StrandShading shading;
  shading.model = uint4(model, 0u, 0u, 0u);
  shading.body = body;
  shading.primary = primary;
  shading.secondary = secondary;
  shading.fiber = fiber;
  return shading;
}

#endif
