// Resources of the kernel that copies depth maps of opaque geometry. Group "opaqueShadow", all in
// space0.
#ifndef PELAGE_SHADOW_LAYOUTS_OPAQUE_SHADOW_HLSLI
#define PELAGE_SHADOW_LAYOUTS_OPAQUE_SHADOW_HLSLI

cbuffer OpaqueShadowConstants : register(b0, space0) {
  uint g_opaqueTexelCount;
  uint g_opaqueFirstWord;  // of the map in g_opaqueWords
  uint g_opaquePad0;
  uint g_opaquePad1;
};

// [y][x]: the bits of depths 0..1, from the engine.
StructuredBuffer<uint> g_opaqueDepth : register(t0, space0);
// All maps, see shading/layouts/opaque_shadow_view.hlsli.
RWStructuredBuffer<uint> g_opaqueWords : register(u0, space0);

#endif
