// The faces of a shadow map, for the kernels that write maps and those that read them; no
// resources. A map of one face is not changed by any of these functions.
#ifndef PELAGE_SHADING_SHADOW_FACES_HLSLI
#define PELAGE_SHADING_SHADOW_FACES_HLSLI

#include "layouts/strand_shadow_view.hlsli"

// Returns the face that a point lies on. \param at the rows mapX, mapY, mapZ and mapW of the point
uint shadowFaceOf(StrandShadowView map, float4 at) {
  float3 size = abs(at.xyw);
  uint face = at.w < 0.0 ? 5u : 4u;
  if (size.y >= size.z) face = at.y < 0.0 ? 3u : 2u;
  if (size.x >= max(size.y, size.z)) face = at.x < 0.0 ? 1u : 0u;
  return map.faceCount < 2u ? 0u : face;
}

// Returns the same as `at` on a face: xy / w the texel, z the distance behind the near plane [m].
float4 onShadowFace(StrandShadowView map, uint face, float4 at) {
  float3 turned = at.xyw;
  if (face < 2u) {
    turned = float3(at.y, at.w, at.x);
  } else if (face < 4u) {
    turned = float3(at.w, at.x, at.y);
  }
  if ((face & 1u) != 0u) turned.z = -turned.z;
  float middle = 0.5 * float(map.width);
  precise float x = turned.x / map.texelSize + middle * turned.z;
  precise float y = turned.y / map.texelSize + middle * turned.z;
  precise float z = turned.z - map.nearW;
  return map.faceCount < 2u ? at : float4(x, y, z, turned.z);
}

// Returns the map of one face.
StrandShadowView shadowFace(StrandShadowView map, uint face) {
  StrandShadowView one = map;
  one.firstWord += face * map.width * map.height * (1u + map.layerCount);
  return one;
}

// Returns the word of a texel's first layer, on a map of one face.
uint firstLayerOf(StrandShadowView map, uint texel) {
  return map.firstWord + map.width * map.height + texel * map.layerCount;
}

bool isProjective(StrandShadowView map) { return dot(map.mapW.xyz, map.mapW.xyz) > 0.0; }

#endif
