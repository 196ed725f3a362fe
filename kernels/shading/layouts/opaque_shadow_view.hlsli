// Depth of opaque geometry as a light sees it, in the buffer of the shadow maps' words; no
// resources.
//
// A map is width x height words, row by row from the top: the bits of a float 0..1, depth in the
// light's clip space.
#ifndef PELAGE_SHADING_LAYOUTS_OPAQUE_SHADOW_VIEW_HLSLI
#define PELAGE_SHADING_LAYOUTS_OPAQUE_SHADOW_VIEW_HLSLI

struct OpaqueShadowView {
  // Rows of the map from a world position to the light's clip space, y up.
  float4 clipX;
  float4 clipY;
  float4 clipZ;
  float4 clipW;
  uint width;  // [texel]
  uint height;
  uint firstWord;      // of the map in the buffer
  uint reversedDepth;  // 0 or 1: depth 1 at the near plane
  float bias;  // [m] >= 0; opaque geometry this close in front of a point does not shadow it
  uint pad0;
  uint pad1;
  uint pad2;
};

#endif
